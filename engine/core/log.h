// One-line messages to standard error; {fmt} format strings. Control characters become '?'.
#pragma once

#include <fmt/format.h>

#include <string_view>

namespace scree {

enum class LogLevel { Debug, Info, Warning, Error };

// Lines below this level are not written. Default: Info.
void setLogLevel(LogLevel level);
void logLine(LogLevel level, std::string_view line);

template <class... T>
void logDebug(fmt::format_string<T...> format, T&&... args) {
  logLine(LogLevel::Debug, fmt::format(format, std::forward<T>(args)...));
}
template <class... T>
void logInfo(fmt::format_string<T...> format, T&&... args) {
  logLine(LogLevel::Info, fmt::format(format, std::forward<T>(args)...));
}
template <class... T>
void logWarning(fmt::format_string<T...> format, T&&... args) {
  logLine(LogLevel::Warning, fmt::format(format, std::forward<T>(args)...));
}
template <class... T>
void logError(fmt::format_string<T...> format, T&&... args) {
  logLine(LogLevel::Error, fmt::format(format, std::forward<T>(args)...));
}

// Ends the program after one line: for broken invariants, never for bad input.
[[noreturn]] void fail(std::string_view line);

}  // namespace scree
