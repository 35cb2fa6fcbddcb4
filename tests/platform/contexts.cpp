// Contexts of every kind on this machine: what they are, and what is said where they cannot be.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <functional>
#include <optional>
#include <string>
#include <thread>

#include "engine/platform/context.h"
#include "engine/platform/input.h"

namespace scree {
namespace {

constexpr unsigned kMajorVersion = 0x821B, kMinorVersion = 0x821C, kContextFlags = 0x821E;
constexpr unsigned kProfileMask = 0x9126;
constexpr int kCoreProfile = 1, kDebugFlag = 2;

int glInteger(const Context& context, unsigned name) {
  int value = -1;
  reinterpret_cast<void (*)(unsigned, int*)>(context.getProcAddress()("glGetIntegerv"))(name,
                                                                                        &value);
  return value;
}

void expectCore45(const Context& context) {
  EXPECT_GE(glInteger(context, kMajorVersion) * 10 + glInteger(context, kMinorVersion), 45);
  EXPECT_TRUE(glInteger(context, kProfileMask) & kCoreProfile);
  EXPECT_TRUE(context.getProcAddress()("glCreateTextures"));
  EXPECT_TRUE(context.getProcAddress()("glClipControl"));
}

// The environment without the variable, for this object's life.
class Unset {
 public:
  explicit Unset(const char* name) : name_(name) {
    if (const char* value = std::getenv(name)) value_ = value;
    unsetenv(name);
  }
  ~Unset() {
    if (value_) setenv(name_, value_->c_str(), 1);
  }

 private:
  const char* name_;
  std::optional<std::string> value_;
};

// A display of its own, so that synthetic keys reach nothing else; DISPLAY is set for its life.
class VirtualDisplay {
 public:
  VirtualDisplay() {
    int fds[2];
    if (pipe(fds) != 0) return;
    child_ = fork();
    if (child_ == 0) {
      close(fds[0]);
      const std::string fd = std::to_string(fds[1]);
      execlp("Xvfb", "Xvfb", "-displayfd", fd.c_str(), "-screen", "0", "800x600x24", "-noreset",
             "-nolisten", "tcp", nullptr);
      _exit(127);
    }
    close(fds[1]);
    std::string number;
    for (char c; read(fds[0], &c, 1) == 1 && c != '\n';) number += c;
    close(fds[0]);
    if (number.empty()) return;
    name_ = ":" + number;
    setenv("DISPLAY", name_.c_str(), 1);
  }
  ~VirtualDisplay() {
    if (child_ > 0) {
      kill(child_, SIGTERM);
      waitpid(child_, nullptr, 0);
    }
  }
  bool ready() const { return !name_.empty(); }

 private:
  Unset outer_{"DISPLAY"};
  pid_t child_ = -1;
  std::string name_;
};

bool runs(const std::string& command) {
  return std::system((command + " >/dev/null 2>&1").c_str()) == 0;
}

// Polls until `done` or 10 s are over; returns whether it is done.
bool pollUntil(Context& context, RawInput& input, const std::function<bool()>& done) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (std::chrono::steady_clock::now() < end) {
    context.poll(input);
    if (done()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

class Offscreen : public testing::TestWithParam<ContextKind> {
 protected:
  void SetUp() override {
    ContextDesc desc;
    desc.kind = GetParam();
    const auto made = makeContext(desc);
    if (!made.ok() && made.error().find("this build has no") != std::string::npos)
      GTEST_SKIP() << made.error();
  }
};

TEST_P(Offscreen, GivesCore45AgainAndAgain) {
  for (int round = 0; round < 3; ++round) {
    ContextDesc desc;
    desc.kind = GetParam();
    desc.size = {333, 217};
    auto made = makeContext(desc);
    ASSERT_TRUE(made.ok()) << made.error();
    Context& context = **made;
    EXPECT_EQ(context.kind(), GetParam());
    EXPECT_EQ(context.framebufferSize(), ivec2(333, 217));
    EXPECT_FALSE(context.presents());
    EXPECT_FALSE(context.shouldClose());
    EXPECT_EQ(context.description().find('\n'), std::string::npos);
    expectCore45(context);
    context.resize({5, 1 << 20});
    EXPECT_EQ(context.framebufferSize(), ivec2(5, kMaxContextSize));
    RawInput input;
    context.poll(input);
    context.swap();
    EXPECT_TRUE(input.events.empty());
  }
}

TEST_P(Offscreen, TwoLiveBesideEachOther) {
  ContextDesc desc;
  desc.kind = GetParam();
  auto first = makeContext(desc), second = makeContext(desc);
  ASSERT_TRUE(first.ok() && second.ok());
  expectCore45(**second);
  (*first)->makeCurrent();
  expectCore45(**first);
  // The end of one leaves the other current.
  second.value().reset();
  expectCore45(**first);
}

std::string kindName(const testing::TestParamInfo<ContextKind>& info) {
  return std::string(contextKindName(info.param));
}
INSTANTIATE_TEST_SUITE_P(Kinds, Offscreen, testing::Values(ContextKind::Egl, ContextKind::OsMesa),
                         kindName);

TEST(Contexts, EglDebugIsAsAsked) {
  for (bool debug : {false, true}) {
    ContextDesc desc;
    desc.kind = ContextKind::Egl;
    desc.debug = debug;
    auto made = makeContext(desc);
    ASSERT_TRUE(made.ok()) << made.error();
    EXPECT_EQ((glInteger(**made, kContextFlags) & kDebugFlag) != 0, debug);
  }
}

TEST(Contexts, ImpossibleSizesAreRefused) {
  for (ivec2 size : {ivec2(0, 10), ivec2(10, -1), ivec2(kMaxContextSize + 1, 10)}) {
    ContextDesc desc;
    desc.kind = ContextKind::Egl;
    desc.size = size;
    const auto made = makeContext(desc);
    ASSERT_FALSE(made.ok());
    EXPECT_EQ(made.error(), "context size is " + std::to_string(size.x) + "x" +
                                std::to_string(size.y) + "; allowed is 1 to 16384 each");
  }
}

TEST(Contexts, WithoutADisplayAWindowIsRefusedInOneLine) {
  Unset display("DISPLAY"), wayland("WAYLAND_DISPLAY");
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  ContextDesc desc;
  desc.kind = ContextKind::Window;
  const auto made = makeContext(desc);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  ASSERT_FALSE(made.ok());
  EXPECT_EQ(made.error().find("no window context: "), 0u) << made.error();
  EXPECT_NE(made.error().find("DISPLAY"), std::string::npos) << made.error();
  EXPECT_EQ(made.error().find('\n'), std::string::npos);
}

TEST(Contexts, AutoFallsBackWithOneLineThatSaysWhy) {
  Unset display("DISPLAY"), wayland("WAYLAND_DISPLAY");
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  const auto made = makeContext({});
  const std::string line = testing::internal::GetCapturedStderr();
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  ASSERT_TRUE(made.ok()) << made.error();
  EXPECT_EQ((*made.value()).kind(), ContextKind::Egl);
  EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1) << line;
  for (const char* part : {"no window context", "DISPLAY", "using egl"})
    EXPECT_NE(line.find(part), std::string::npos) << line;
}

TEST(ContextsDeath, AnOlderDriverIsRefused) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto try_old = [](ContextKind kind) {
    setenv("MESA_GL_VERSION_OVERRIDE", "3.3", 1);
    ContextDesc desc;
    desc.kind = kind;
    const auto made = makeContext(desc);
    fprintf(stderr, "%s\n",
            made.ok() ? (*made.value()).description().c_str() : made.error().c_str());
    _exit(made.ok() ? 0 : 7);
  };
  EXPECT_EXIT(try_old(ContextKind::Egl), testing::ExitedWithCode(7), "^no egl context: .*4\\.5");
  EXPECT_EXIT(try_old(ContextKind::OsMesa), testing::ExitedWithCode(7),
              "^no osmesa context: .*(4\\.5|this build has no)");
}

TEST(Contexts, AWindowShowsResizesAndReadsKeysAndMouse) {
  VirtualDisplay display;
  if (!display.ready()) GTEST_SKIP() << "Xvfb is not installed";
  for (int round = 0; round < 2; ++round) {
    ContextDesc desc;
    desc.kind = ContextKind::Window;
    desc.size = {320, 200};
    desc.title = "scree window test";
    desc.debug = true;
    auto made = makeContext(desc);
    ASSERT_TRUE(made.ok()) << made.error();
    Context& context = **made;
    EXPECT_EQ(context.kind(), ContextKind::Window);
    EXPECT_TRUE(context.presents());
    EXPECT_FALSE(context.shouldClose());
    EXPECT_FALSE(context.minimised());
    EXPECT_TRUE(glInteger(context, kContextFlags) & kDebugFlag);
    expectCore45(context);
    RawInput input;
    EXPECT_TRUE(
        pollUntil(context, input, [&] { return context.framebufferSize() == ivec2(320, 200); }));
    context.setVsync(false);
    context.swap();
    context.resize({400, 300});
    EXPECT_TRUE(
        pollUntil(context, input, [&] { return context.framebufferSize() == ivec2(400, 300); }));
    if (!runs("xdotool version")) GTEST_SKIP() << "xdotool is not installed";
    context.setTitle("scree renamed");
    EXPECT_TRUE(
        pollUntil(context, input, [&] { return runs("xdotool search --name 'scree renamed'"); }));

    const auto seen = [&](Source source, float value) {
      return std::any_of(input.events.begin(), input.events.end(), [&](const RawEvent& event) {
        return event.source == source && event.value == value;
      });
    };
    ASSERT_TRUE(runs("xdotool mousemove 100 100 mousemove 110 95 keydown w"));
    EXPECT_TRUE(pollUntil(context, input, [&] { return seen(Source::KeyW, 1); }));
    EXPECT_FALSE(seen(Source::KeyW, 0));
    ASSERT_TRUE(runs("xdotool keyup w key space mousedown 1 mouseup 1 click 4"));
    EXPECT_TRUE(pollUntil(context, input, [&] { return seen(Source::MouseWheel, 1); }));
    EXPECT_TRUE(seen(Source::KeyW, 0));
    EXPECT_TRUE(seen(Source::KeySpace, 1) && seen(Source::KeySpace, 0));
    EXPECT_TRUE(seen(Source::MouseLeft, 1) && seen(Source::MouseLeft, 0));
    input.events.clear();
    ASSERT_TRUE(runs("xdotool mousemove 200 200"));
    EXPECT_TRUE(pollUntil(context, input, [&] { return seen(Source::MouseY, 105); }));
    EXPECT_TRUE(seen(Source::MouseX, 90));
  }
}

TEST(Contexts, AutoTakesTheWindowWhereThereIsADisplay) {
  VirtualDisplay display;
  if (!display.ready()) GTEST_SKIP() << "Xvfb is not installed";
  const auto made = makeContext({});
  ASSERT_TRUE(made.ok()) << made.error();
  EXPECT_EQ((*made.value()).kind(), ContextKind::Window);
}

}  // namespace
}  // namespace scree
