// The insides of Frame: resources and passes, resolved to numbers. Private to engine/frame.
#pragma once

#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "engine/frame/activity.h"
#include "engine/frame/frame.h"
#include "engine/gpu/timers.h"

namespace scree {

struct FrameResource {
  std::string name;
  bool target = false;  // else external
  bool depth = false;
  TargetDesc desc;
  gpu::Texture texture;
  uint64_t created = 0;  // how often `texture` was created
  // Barrier bits that the next access of each kind needs, because a shader wrote, ...
  uint32_t unread_writes = 0;
  // ... and those that the next storage write needs, because somebody read.
  uint32_t unfinished_reads = 0;
};

struct FrameUse {
  uint16_t resource = 0;
  Access access = Access::Sampled;
  bool attached = false;  // in the pass's framebuffer, as of its last run
};

struct FramePass {
  PassDesc desc;
  std::vector<FrameUse> uses;
  bool attached = false;      // has attachments
  bool depth_tested = false;  // has a depth attachment
  bool depth_written = false;
  ivec2 fixed_size{0, 0};  // of the attachments; zero: the output's
  int timer = 0;
  gpu::Framebuffer framebuffer;
  uint64_t targets_created = 0;  // sum of `created` of the attachments in `framebuffer`
  uint64_t written_created = 0;  // the same over the targets that it writes, at its last run
  uint64_t last_run = 0;         // State::runs at its last run; 0: never
  // Texts of PassReport::why: by verdict, then by missing resource.
  std::vector<std::string> reasons;
  PassDecision reported;
};

struct NameHash {
  using is_transparent = void;
  size_t operator()(std::string_view name) const { return std::hash<std::string_view>()(name); }
};

struct Frame::State {
  std::vector<FrameResource> resources;
  std::unordered_map<std::string, uint16_t, NameHash, std::equal_to<>> resource_of_name;
  // In frame order; the three run in step.
  std::vector<std::unique_ptr<FramePass>> passes;
  std::vector<PassRules> rules;
  std::vector<PassReport> reports;

  std::vector<uint8_t> needs_met;     // by pass
  std::vector<uint8_t> read_outside;  // by resource
  Activity activity;
  gpu::Timers timers;
  ivec2 size{0, 0};
  uint64_t runs = 0;
  bool running = false;
  bool separate = false;

  const FrameResource* find(std::string_view name) const;
  FrameResource* find(std::string_view name);
  uint16_t number(std::string_view name) const;  // ends the program if it is unknown
  void addResource(FrameResource resource);
  void report(size_t pass);
  void takeTimes();

  void create(FrameResource& resource);
  void resize(ivec2 output);
  void prepareTargets(FramePass& pass);
  void issueBarriers(const FramePass& pass);
  void noteAccesses(const FramePass& pass);
  void clearTargets(const FramePass& pass);
  void runPass(size_t index, Frame& frame, const FrameInput& input);
};

bool isAttachment(Access access);
std::string_view accessName(Access access);

}  // namespace scree
