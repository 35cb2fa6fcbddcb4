// fork and exec, with both streams read until they close.
#include "tests/game/support/program.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>

namespace scree::hourglass {
namespace fs = std::filesystem;

ProgramRun runCommand(const std::string& path, const std::vector<std::string>& arguments,
                      const std::vector<std::string>& environment, int timeout_s) {
  std::array<std::array<int, 2>, 2> pipes;
  for (auto& pipe : pipes)
    if (::pipe(pipe.data()) != 0) return {};
  const pid_t child = fork();
  if (child == 0) {
    dup2(pipes[0][1], STDOUT_FILENO);
    dup2(pipes[1][1], STDERR_FILENO);
    const int null = open("/dev/null", O_RDONLY);
    dup2(null, STDIN_FILENO);
    for (auto& pipe : pipes)
      for (int end : pipe) close(end);
    unsetenv("DISPLAY");
    unsetenv("WAYLAND_DISPLAY");
    for (const std::string& variable : environment) putenv(const_cast<char*>(variable.c_str()));
    std::vector<char*> argv{const_cast<char*>(path.c_str())};
    for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    alarm(static_cast<unsigned>(timeout_s));
    execv(path.c_str(), argv.data());
    _exit(127);
  }
  ProgramRun run;
  std::array<std::string*, 2> texts{&run.out, &run.err};
  std::array<pollfd, 2> polls;
  for (int i = 0; i < 2; ++i) {
    close(pipes[i][1]);
    polls[i] = {pipes[i][0], POLLIN, 0};
  }
  int open_streams = 2;
  while (open_streams > 0 && poll(polls.data(), polls.size(), -1) > 0) {
    for (int i = 0; i < 2; ++i) {
      if (polls[i].fd < 0 || polls[i].revents == 0) continue;
      std::array<char, 4096> buffer;
      const ssize_t count = read(polls[i].fd, buffer.data(), buffer.size());
      if (count > 0) {
        texts[i]->append(buffer.data(), static_cast<size_t>(count));
      } else {
        close(polls[i].fd);
        polls[i].fd = -1;
        --open_streams;
      }
    }
  }
  int status = 0;
  waitpid(child, &status, 0);
  run.status = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  return run;
}

ProgramRun runProgram(const std::string& program, const std::vector<std::string>& arguments,
                      int timeout_s, const std::vector<std::string>& environment) {
  return runCommand((fs::path(SCREE_BINARY_DIR) / "bin" / program).string(), arguments, environment,
                    timeout_s);
}

fs::path scratchFolder(const std::string& name) {
  const fs::path folder = fs::path(SCREE_BINARY_DIR) / "scratch" / name;
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

}  // namespace scree::hourglass
