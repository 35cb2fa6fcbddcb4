// Runs the built programs as a user does, and keeps what they say.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace scree::hourglass {

struct ProgramRun {
  int status = -1;  // exit status; 128 + n: ended by signal n
  std::string out, err;
};

// Runs the program at `path` in this environment without a display, but with what `environment`
// sets ("NAME=value"); at most `timeout_s` seconds.
ProgramRun runCommand(const std::string& path, const std::vector<std::string>& arguments,
                      const std::vector<std::string>& environment, int timeout_s);

// The same for build/bin/<program>.
ProgramRun runProgram(const std::string& program, const std::vector<std::string>& arguments,
                      int timeout_s = 300, const std::vector<std::string>& environment = {});

// A folder of this test's own under the build folder, empty.
std::filesystem::path scratchFolder(const std::string& name);

}  // namespace scree::hourglass
