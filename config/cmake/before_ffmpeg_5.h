// What C++ written before FFmpeg 5 calls and later ones lack. users_packages.cmake includes it first.
#pragma once

extern "C" {
#include <libavcodec/avcodec.h>
}

#if LIBAVCODEC_VERSION_MAJOR >= 59
// avcodec_alloc_context3() has set a codec's defaults already.
inline int avcodec_get_context_defaults3(AVCodecContext *, const AVCodec *) { return 0; }
// Since 4 codecs are registered without these, and lock for themselves.
inline void avcodec_register_all() {}
inline void av_register_all() {}
enum AVLockOp { AV_LOCK_CREATE, AV_LOCK_OBTAIN, AV_LOCK_RELEASE, AV_LOCK_DESTROY };
inline int av_lockmgr_register(int (*)(void **, AVLockOp)) { return 0; }

#if __has_include(<libavformat/avformat.h>)
#include <cstdint>
#include <sys/mman.h>
#include <unistd.h>
extern "C" {
#include <libavformat/avformat.h>
}
// A format's flags may be written, as before its const, which put it into pages that are only read.
inline AVOutputFormat *paddock_guess_format(const char *name, const char *file, const char *type) {
  const AVOutputFormat *format = av_guess_format(name, file, type);
  const auto at = reinterpret_cast<std::uintptr_t>(format);
  const auto begin = at & ~std::uintptr_t(sysconf(_SC_PAGESIZE) - 1);
  if (format)
    mprotect(reinterpret_cast<void *>(begin), at + sizeof(*format) - begin, PROT_READ | PROT_WRITE);
  return const_cast<AVOutputFormat *>(format);
}
#define av_guess_format paddock_guess_format
#endif
#endif
