// Which plugin throws, crashes or never returns: by the libraries that are on the stack.
#pragma once
#include <string>

namespace paddock {

// Handle signals of crashes, and watch for calls that do not return.
void watchFaults();

// Load a library as Gazebo does; returns why it cannot be, or an empty text.
std::string loadLibrary(const std::string &path);

// Enters a plugin while its library is known by this; what is entered stays.
struct Owner {
  Owner(const std::string &library, const std::string &plugin, const std::string &model);
  ~Owner();
};

void forgetPlugins(const std::string &model);

// While it lives, this thread is in code of plugins.
struct Watch {
  Watch();
  ~Watch();
};

// The message of what was thrown last, if it was since the last call; the thrower stays known.
bool takeThrown(std::string *message);

// Plugin that has thrown last, for messages; empty: unknown. Its model and name; a model "": the
// world's.
std::string faulty(std::string *model, std::string *plugin);

// Let the libraries' sockets listen on the loopback interface alone; whether that is so.
bool keepToLoopback();

}  // namespace paddock
