#include "faults.hh"

#include <cxxabi.h>
#include <dlfcn.h>
#include <execinfo.h>
#include <gazebo/gazebo_config.h>
#include <pthread.h>
#include <signal.h>
#include <string.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <map>
#include <mutex>
#include <thread>
#include <typeinfo>
#include <vector>

#define TEXT_OF(number) #number
#define TEXT(number) TEXT_OF(number)
#define VERSION TEXT(GAZEBO_MAJOR_VERSION)

namespace paddock {
namespace {

constexpr int MAX_FRAMES = 64;
constexpr double PATIENCE = 10.0;  // [s] after which a call that has not returned is told of
const int ASK = SIGRTMIN + 7;      // asks the watched thread where it is

struct Plugin {
  std::string library, name, model;
};

std::mutex g_plugins_mutex;
std::vector<Plugin> g_plugins;
std::string g_thrown_by, g_message;
bool g_has_thrown = false;
thread_local int t_watched = 0;
std::atomic<double> g_since{0.0};  // [s] when a Watch began; 0: there is none
std::atomic<pthread_t> g_thread{};

double now() {
  using namespace std::chrono;
  return duration<double>(steady_clock::now().time_since_epoch()).count();
}

std::string real(const char *path) {
  char buffer[4096];
  return realpath(path, buffer) ? buffer : path;
}

std::string demangled(const char *name) {
  int status = 0;
  char *text = abi::__cxa_demangle(name, nullptr, nullptr, &status);
  const std::string result = status == 0 ? text : name;
  free(text);
  return result;
}

// "plugin 'p' of model 'm' (libp.so, in f())" for the innermost address that is in a plugin.
std::string where(void *const *addresses, int count) {
  for (int i = 0; i < count; ++i) {
    Dl_info info;
    if (!dladdr(addresses[i], &info) || !info.dli_fname) continue;
    const std::string library = real(info.dli_fname);
    std::string text;
    for (const auto &plugin : g_plugins) {
      if (plugin.library != library) continue;
      text += text.empty() ? "" : " or ";
      text += "plugin '" + plugin.name + "'";
      text += plugin.model.empty() ? " of the world" : " of model '" + plugin.model + "'";
    }
    if (text.empty()) continue;
    text += " (" + library.substr(library.rfind('/') + 1);
    return text + (info.dli_sname ? ", in " + demangled(info.dli_sname) + ")" : ")");
  }
  return "";
}

std::string here() {
  void *addresses[MAX_FRAMES];
  return where(addresses, backtrace(addresses, MAX_FRAMES));
}

void say(const std::string &text) {
  if (write(STDERR_FILENO, text.data(), text.size()) < 0) return;
}

// A crash names the plugin, then ends the process as it would have without this.
void onCrash(int number) {
  const std::string place = here();
  say(std::string("[FATAL] the simulator ends by ") + strsignal(number) +
      (place.empty() ? ", in no plugin that is known" : " in " + place) + "\n");
  raise(number);
}

void onAsked(int) {
  const std::string place = here();
  if (place.empty()) return;
  say("[ERROR] " + place + " has not returned for 10 s; the simulation waits for it\n");
}

void watch() {
  double told = 0.0;
  while (true) {
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    const double since = g_since;
    if (since == 0.0 || since == told || now() - since < PATIENCE) continue;
    told = since;
    pthread_kill(g_thread, ASK);
  }
}

}  // namespace

void watchFaults() {
  void *address;
  backtrace(&address, 1);  // it loads a library the first time
  static char stack[256 * 1024];
  stack_t alternative{};
  alternative.ss_sp = stack, alternative.ss_size = sizeof stack;
  sigaltstack(&alternative, nullptr);
  struct sigaction action{};
  action.sa_handler = onCrash;
  action.sa_flags = SA_ONSTACK | SA_RESETHAND | SA_NODEFER;
  for (int number : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) sigaction(number, &action, nullptr);
  struct sigaction asked{};
  asked.sa_handler = onAsked;
  asked.sa_flags = SA_RESTART;
  sigaction(ASK, &asked, nullptr);
  std::thread(watch).detach();
}

// All symbols are looked up at once: one that is missing would end the process when it is called.
std::string loadLibrary(const std::string &path) {
  if (dlopen(path.c_str(), RTLD_NOW | RTLD_GLOBAL)) return "";
  // Libraries that Gazebo's server has and that are not there yet. Those of sensors need others, which
  // are found by what names them all: ours.
  Dl_info own;
  if (dladdr(reinterpret_cast<void *>(&watchFaults), &own) && own.dli_fname) {
    const std::string here = real(own.dli_fname);
    const auto sensors = here.substr(0, here.rfind('/')) + "/libbullet_gazebo_sensors.so";
    dlopen(sensors.c_str(), RTLD_LAZY | RTLD_GLOBAL);
  }
  for (const char *name : {"gazebo_sensors", "gazebo_rendering", "gazebo_client", "gazebo"})
    dlopen(("lib" + std::string(name) + ".so." VERSION).c_str(), RTLD_LAZY | RTLD_GLOBAL);
  if (dlopen(path.c_str(), RTLD_NOW | RTLD_GLOBAL)) return "";
  std::string reason = dlerror();
  const auto at = reason.find("undefined symbol: ");
  if (at != std::string::npos)
    reason = reason.substr(0, at + 18) + demangled(reason.c_str() + at + 18);
  return reason;
}

Owner::Owner(const std::string &library, const std::string &plugin, const std::string &model) {
  std::lock_guard<std::mutex> lock(g_plugins_mutex);
  g_plugins.push_back({real(library.c_str()), plugin, model});
  g_since = now(), g_thread = pthread_self(), ++t_watched;
}

Owner::~Owner() { g_since = 0.0, --t_watched; }

void forgetPlugins(const std::string &model) {
  std::lock_guard<std::mutex> lock(g_plugins_mutex);
  std::vector<Plugin> others;
  for (const auto &plugin : g_plugins)
    if (plugin.model != model) others.push_back(plugin);
  g_plugins.swap(others);
}

Watch::Watch() { g_since = now(), g_thread = pthread_self(), ++t_watched; }

Watch::~Watch() { g_since = 0.0, --t_watched; }

bool takeThrown(std::string *message) {
  std::lock_guard<std::mutex> lock(g_plugins_mutex);
  if (!g_has_thrown) return false;
  g_has_thrown = false, *message = g_message;
  return true;
}

std::string faulty(std::string *model, std::string *plugin) {
  std::lock_guard<std::mutex> lock(g_plugins_mutex);
  for (const auto &each : g_plugins) {
    if (each.library != g_thrown_by) continue;
    *model = each.model, *plugin = each.name;
    const std::string holder = each.model.empty() ? "the world" : "model '" + each.model + "'";
    return "plugin '" + each.name + "' of " + holder + " (" +
           each.library.substr(each.library.rfind('/') + 1) + ")";
  }
  return "";
}

void noteThrown(void *object, std::type_info *type) {
  void *addresses[MAX_FRAMES];
  const int count = backtrace(addresses, MAX_FRAMES);
  std::lock_guard<std::mutex> lock(g_plugins_mutex);
  for (int i = 0; i < count; ++i) {
    Dl_info info;
    if (!dladdr(addresses[i], &info) || !info.dli_fname) continue;
    const std::string library = real(info.dli_fname);
    for (const auto &plugin : g_plugins) {
      if (plugin.library != library) continue;
      g_thrown_by = library, g_has_thrown = true;
      g_message = "it has thrown " + demangled(type->name());
      void *pointer = object;
      if (typeid(std::exception).__do_catch(type, &pointer, 1))
        g_message += std::string(": ") + static_cast<std::exception *>(pointer)->what();
      return;
    }
  }
}

bool isWatched() { return t_watched > 0; }

}  // namespace paddock

// Libraries that are loaded after this one throw by this function: a plugin that throws is known,
// which a handler in Gazebo would hide.
extern "C" __attribute__((noreturn, visibility("default"))) void __cxa_throw(
    void *object, void *type, void (*destructor)(void *)) {
  using Throw = void (*)(void *, void *, void (*)(void *));
  static const auto next = reinterpret_cast<Throw>(dlsym(RTLD_NEXT, "__cxa_throw"));
  if (paddock::isWatched()) paddock::noteThrown(object, static_cast<std::type_info *>(type));
  next(object, type, destructor);
  __builtin_unreachable();
}
