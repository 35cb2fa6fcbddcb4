// The frame: an ordered list of passes in stages, of which only those run that the scene needs.
//
// A pass is on when
//   1. its `needs` is met (a cached query that is not empty, or nothing is needed),
//   2. every resource named in `needs_content` was written this frame by a pass that is on, and
//   3. some resource that it writes is read by a later pass that is on, is the frame's output, or
//      is kept (see keep()).
// The passes that are on are the largest set that obeys these rules. "Written" in rule 2 means by
// an earlier pass, and not with Access::Clear. Access::Depth and Access::StorageWrite count as
// reads too in rule 3. An off pass costs these tests and nothing else: its programs and targets are
// never created.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/math.h"
#include "engine/gpu/counters.h"
#include "engine/gpu/objects.h"

namespace scree {


// The frame, top to bottom. Within a stage, passes run in the order of their registration.
enum class Stage : uint8_t {
  Route,         // what is drawn, and as what
  Geometry,      // G-buffer and shadow maps
  DepthPyramid,  // depth of what was drawn so far
  RouteLate,     // second chance for what the old depth hid wrongly
  GeometryLate,  // what else is drawn, and surfaces of what was
  Emission,      // what emits light, over all geometry: nothing that is drawn later could hide it
  Shade,    // G-buffer to linear radiance
  Lens,     // depth of field, motion blur, accumulation
  Present,  // tone mapping, overlays: writes the output
};
std::string_view stageName(Stage stage);

enum class Access : uint8_t {
  Clear,         // initialises a target, attached like Color or Depth; it still counts as empty
  Color,         // color attachment, in the order of declaration; not attached (nor created) in
                 // frames in which nobody reads it, as long as the pass has another attachment
  Depth,         // depth attachment, tested and written
  DepthTest,     // depth attachment, tested only
  Sampled,       // read through a sampler
  StorageRead,   // storage buffer or image, read
  StorageWrite,  // storage buffer or image, written (and perhaps read)
  Indirect,      // source of indirect commands
  Vertex,        // vertex or index buffer
  Uniform,       // uniform buffer
};
bool isWrite(Access access);
bool isRead(Access access);

struct Use {
  std::string resource;
  Access access;
};

// What one rendered frame is asked for. World singleton, set by App before Phase::Prepare.
struct FrameInput {
  ivec2 size{0, 0};        // output, pixels
  uint64_t frame = 0;      // rendered frames so far
  uint64_t tick = 0;       // simulation ticks so far
  float alpha = 1;         // interpolation between previous (0) and current (1) tick
  float motion_scale = 1;  // frame interval / tick interval: scales tick motion to frame motion
  int sample = 0;          // truth mode: this sample's index, 0 .. sample_count - 1
  int sample_count = 1;    // truth mode: samples a pixel; 1 = off
  vec2 jitter_px{0, 0};    // truth mode: sub-pixel offset of this sample, within +-0.5
};

class Frame;

struct PassContext {
  Frame& frame;
  const FrameInput& input;
  // The pass did not run in the last frame, or a target that it writes was created since it did:
  // history that it keeps (accumulated frames, previous depth) is to be dropped.
  bool first_run_after_off = false;
  // The pass's own framebuffer, bound; null for a pass without attachments.
  const gpu::Framebuffer* framebuffer = nullptr;
};

struct PassDesc {
  std::string name;  // "module.verb"; timer and debug-group label
  Stage stage = Stage::Shade;
  std::string needs_text;       // what `needs` asks for, for --print-frame: "a mesh instance"
  std::function<bool()> needs;  // empty: always met
  std::vector<std::string> needs_content;
  std::vector<Use> uses;
  // Runs while the next ticks are simulated: it touches no component, and of what systems of
  // Phase::Input and Phase::Simulate write nothing but copies that Phase::Prepare made.
  // Called with the framebuffer of the Clear, Color, Depth and DepthTest uses bound (color
  // attachments in the order of declaration), the viewport set to its size, no scissor, and the
  // default DrawState (see engine/gpu/state.h) applied, with depth test and depth writes as far as
  // the uses allow. Empty: the pass clears its Clear uses to their clear_value, and has no others.
  std::function<void(PassContext&)> run;
};

// A two-dimensional render target. Created, with zeros, when a pass that attaches it or writes it
// as storage first runs, or a pass that only reads it asks for it by texture(); recreated when the
// output size changes and `fixed_size` is zero.
struct TargetDesc {
  unsigned format = 0;     // sized internal format, e.g. GL_RGBA8
  ivec2 fixed_size{0, 0};  // zero: the output's size
  int levels = 1;          // mip levels; 0: the full chain
  int layers = 1;          // more than 1: an array texture, attached with all its layers
  vec4 clear_value{0};     // of passes that clear without code of their own
  gpu::Sampling sampling;
};

struct PassReport {
  std::string name;
  Stage stage = Stage::Shade;
  bool on = false;
  std::string why;            // "on", or what is missing
  double gpu_ms = -1;         // last known GPU time; negative: not measured yet
  double cpu_ms = 0;          // of the last run
  int64_t start_ns = 0;       // steady clock, when the last run began on the CPU
  int64_t gpu_start_ns = -1;  // the GPU's own clock, of the measurement gpu_ms; negative: none yet
  uint64_t runs = 0;          // since the start
  gpu::Counters counters;     // what the last run did
};

class Frame {
 public:
  Frame();
  ~Frame();
  Frame(const Frame&) = delete;
  Frame& operator=(const Frame&) = delete;

  // The final image: RGBA8, sRGB-encoded. Passes of Stage::Present write it.
  static constexpr std::string_view kOutput = "frame.output";

  void addTarget(std::string name, TargetDesc desc);
  // A buffer or texture that a module owns and passes name in their uses, though not as attachment.
  // The module binds it. May be declared again.
  void addExternal(std::string name);
  // Refuses (ends the program with one line) two passes of one name, an undeclared resource, a
  // pass that writes nothing (it could never be on), that samples what it draws to, or whose
  // attachments differ in size.
  void addPass(PassDesc desc);

  // Marks a resource as read from outside the frame (capture of the id buffer): its writers stay
  // on.
  void keep(std::string_view resource, bool kept);

  // Decides which passes are on, calls `decided`, then runs the passes in order. An output of no
  // size (a minimised window) runs nothing.
  void run(const FrameInput& input, const std::function<void()>& decided = {});
  // Only decides, without touching GL: report() and describe() then tell what run() would do.
  void decide();

  // True: GPU work is flushed after every pass, so that a driver that batches passes cannot book
  // the time of one to another (--stats, --trace); costs a little. Default: false.
  void separatePasses(bool separate);
  // Waits for the GPU times still on their way, and puts them into report().
  void finishTimers();

  // The target's texture. If it does not exist yet, it is created for a pass that is on and
  // declares it; in any other case the program ends.
  const gpu::Texture& texture(std::string_view name) const;
  bool hasTexture(std::string_view name) const;
  // Binds the target for sampling; if it does not exist, one texel of zeros of the same kind.
  void bindSampled(std::string_view name, unsigned unit) const;
  // True in a frame in which a pass that is on wrote the resource.
  bool hasContent(std::string_view name) const;
  // True in a frame in which a pass that is on reads the resource, or it is kept. A color target
  // that is not read is not attached: a pass need not compute what it would hold.
  bool isRead(std::string_view name) const;

  // For PassDesc::needs: true if the resource is kept, or read by a pass whose needs are met; the pass
  // named `besides` does not count (nor may its needs ask for the same resource without naming it).
  bool isWanted(std::string_view resource, std::string_view besides) const;

  // One entry a pass, in frame order, of the last run() or decide().
  const std::vector<PassReport>& report() const;
  // The text of --print-frame: stages, passes, on or off and why, resources read and written.
  std::string describe() const;

  // How often the pass ran since the start; 0 for an unknown name.
  uint64_t runCount(std::string_view pass) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace scree
