// A sink of glog as it was before 0.6, with the time of a message as a std::tm, for ToString().
// users_packages.cmake includes it first.
#pragma once

#include <ctime>
#include <string>

#include <glog/logging.h>

namespace google {

class SinkOfTm : public LogSink {
 public:
  using LogSink::ToString;
  static std::string ToString(LogSeverity severity, const char *file, int line, const std::tm *time,
                              const char *message, size_t length) {
    std::tm copy = *time;
    const std::time_t seconds = std::mktime(&copy);  // of a tm alone microseconds are undefined
    const LogMessageTime stamp(seconds, static_cast<WallTime>(seconds));
    return LogSink::ToString(severity, file, line, stamp, message, length);
  }
};

}  // namespace google

#define LogSink SinkOfTm
