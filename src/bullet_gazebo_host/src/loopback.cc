// Sockets of Gazebo's, Ignition's and ROS's libraries listen on the loopback interface alone.
//
// Whatever GAZEBO_IP, IGN_IP and ROS_IP say, these libraries bind some sockets to every interface.
// The calls of bind() go through slots of each library's own table, which are written here.
#include <elf.h>
#include <link.h>
#include <netinet/in.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstring>

#include "faults.hh"

namespace paddock {
namespace {

const char *const LIBRARIES[] = {"libgazebo_transport", "libignition-transport", "libxmlrpcpp",
                                 "libroscpp", "libzmq"};

#if defined(__x86_64__)
constexpr unsigned SLOTS[] = {R_X86_64_JUMP_SLOT, R_X86_64_GLOB_DAT};
#elif defined(__aarch64__)
constexpr unsigned SLOTS[] = {R_AARCH64_JUMP_SLOT, R_AARCH64_GLOB_DAT};
#else
#error "the relocations of this processor are not known"
#endif

int bindToLoopback(int socket, const sockaddr *address, socklen_t size) {
  if (address->sa_family == AF_INET && size >= sizeof(sockaddr_in)) {
    sockaddr_in own;
    memcpy(&own, address, sizeof own);
    if (own.sin_addr.s_addr == INADDR_ANY) own.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return ::bind(socket, reinterpret_cast<sockaddr *>(&own), sizeof own);
  }
  if (address->sa_family == AF_INET6 && size >= sizeof(sockaddr_in6)) {
    sockaddr_in6 own;
    memcpy(&own, address, sizeof own);
    if (IN6_IS_ADDR_UNSPECIFIED(&own.sin6_addr)) own.sin6_addr = in6addr_loopback;
    return ::bind(socket, reinterpret_cast<sockaddr *>(&own), sizeof own);
  }
  return ::bind(socket, address, size);
}

bool isOurs(const char *path) {
  for (const char *name : LIBRARIES)
    if (strstr(path, name)) return true;
  return false;
}

bool isSlot(unsigned type) { return type == SLOTS[0] || type == SLOTS[1]; }

bool writeSlot(void **slot) {
  const long size = sysconf(_SC_PAGESIZE);
  void *page = reinterpret_cast<void *>(reinterpret_cast<size_t>(slot) & ~(size - 1));
  if (mprotect(page, size, PROT_READ | PROT_WRITE) != 0) return false;
  *slot = reinterpret_cast<void *>(bindToLoopback);
  return true;
}

struct Relocations {
  const ElfW(Rela) *first = nullptr;
  size_t size = 0;
};

// Write the slots of one library; failed: whether one could not be.
int writeSlots(dl_phdr_info *library, size_t, void *failed) {
  if (!library->dlpi_name || !isOurs(library->dlpi_name)) return 0;
  const ElfW(Dyn) *entry = nullptr;
  for (int k = 0; k < library->dlpi_phnum; ++k)
    if (library->dlpi_phdr[k].p_type == PT_DYNAMIC)
      entry = reinterpret_cast<const ElfW(Dyn) *>(
          library->dlpi_addr + library->dlpi_phdr[k].p_vaddr);
  if (!entry) return 0;
  const char *names = nullptr;
  const ElfW(Sym) *symbols = nullptr;
  Relocations tables[2];
  for (; entry->d_tag != DT_NULL; ++entry) {
    const auto value = entry->d_un.d_ptr;
    if (entry->d_tag == DT_STRTAB) names = reinterpret_cast<const char *>(value);
    if (entry->d_tag == DT_SYMTAB) symbols = reinterpret_cast<const ElfW(Sym) *>(value);
    if (entry->d_tag == DT_JMPREL) tables[0].first = reinterpret_cast<const ElfW(Rela) *>(value);
    if (entry->d_tag == DT_PLTRELSZ) tables[0].size = value;
    if (entry->d_tag == DT_RELA) tables[1].first = reinterpret_cast<const ElfW(Rela) *>(value);
    if (entry->d_tag == DT_RELASZ) tables[1].size = value;
  }
  for (const auto &table : tables) {
    for (size_t k = 0; k < table.size / sizeof(ElfW(Rela)); ++k) {
      const auto &each = table.first[k];
      const char *name = names + symbols[ELF64_R_SYM(each.r_info)].st_name;
      if (!isSlot(ELF64_R_TYPE(each.r_info)) || strcmp(name, "bind") != 0) continue;
      if (!writeSlot(reinterpret_cast<void **>(library->dlpi_addr + each.r_offset)))
        *static_cast<bool *>(failed) = true;
    }
  }
  return 0;
}

}  // namespace

bool keepToLoopback() {
  bool failed = false;
  dl_iterate_phdr(writeSlots, &failed);
  return !failed;
}

}  // namespace paddock
