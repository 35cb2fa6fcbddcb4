// Log lines go to standard error through spdlog, so that standard output stays machine-readable.
#include "engine/core/log.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdlib>
#include <string>

namespace scree {
namespace {

// Bytes of a line that are written; what is longer is cut.
constexpr size_t kMaxLine = 2000;

spdlog::logger& logger() {
  static spdlog::logger instance = [] {
    spdlog::logger made("scree", std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
    made.set_pattern("%^%l%$: %v");
    return made;
  }();
  return instance;
}

spdlog::level::level_enum toSpdlog(LogLevel level) {
  switch (level) {
    case LogLevel::Debug: return spdlog::level::debug;
    case LogLevel::Info: return spdlog::level::info;
    case LogLevel::Warning: return spdlog::level::warn;
    case LogLevel::Error: return spdlog::level::err;
  }
  return spdlog::level::err;
}

}  // namespace

void setLogLevel(LogLevel level) { logger().set_level(toSpdlog(level)); }

void logLine(LogLevel level, std::string_view line) {
  std::string shown(line.substr(0, kMaxLine));
  if (line.size() > kMaxLine) shown += "...";
  // Names and values from files and flags may hold what moves a terminal's cursor.
  std::replace_if(
      shown.begin(), shown.end(), [](unsigned char c) { return c < 32 || c == 127; }, '?');
  logger().log(toSpdlog(level), shown);
}

void fail(std::string_view line) {
  logLine(LogLevel::Error, line);
  std::abort();
}

}  // namespace scree
