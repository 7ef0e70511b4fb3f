// What C++ written before FFmpeg 5 calls and later ones lack. users_packages.cmake includes it first.
#pragma once

extern "C" {
#include <libavcodec/avcodec.h>
}

#if LIBAVCODEC_VERSION_MAJOR >= 59
// avcodec_alloc_context3() has set a codec's defaults already.
inline int avcodec_get_context_defaults3(AVCodecContext *, const AVCodec *) { return 0; }
#endif
