// Registration of targets and passes, and what can be asked about the frame.
#include "engine/frame/frame.h"

#include <algorithm>
#include <limits>

#include "engine/core/log.h"
#include "engine/frame/frame_state.h"
#include "engine/gpu/format.h"
#include "engine/gpu/gl.h"

namespace scree {

std::string_view stageName(Stage stage) {
  switch (stage) {
    case Stage::Route:
      return "Route";
    case Stage::Geometry:
      return "Geometry";
    case Stage::DepthPyramid:
      return "DepthPyramid";
    case Stage::RouteLate:
      return "RouteLate";
    case Stage::GeometryLate:
      return "GeometryLate";
    case Stage::Emission:
      return "Emission";
    case Stage::Shade:
      return "Shade";
    case Stage::Lens:
      return "Lens";
    case Stage::Present:
      return "Present";
  }
  return "";
}

bool isWrite(Access access) {
  return access == Access::Clear || access == Access::Color || access == Access::Depth ||
         access == Access::StorageWrite;
}

bool isRead(Access access) {
  return access != Access::Clear && access != Access::Color;
}

bool isAttachment(Access access) {
  return access == Access::Clear || access == Access::Color || access == Access::Depth ||
         access == Access::DepthTest;
}

const FrameResource* Frame::State::find(std::string_view name) const {
  const auto found = resource_of_name.find(name);
  return found == resource_of_name.end() ? nullptr : &resources[found->second];
}

FrameResource* Frame::State::find(std::string_view name) {
  return const_cast<FrameResource*>(std::as_const(*this).find(name));
}

uint16_t Frame::State::number(std::string_view name) const {
  const FrameResource* resource = find(name);
  if (!resource) fail(fmt::format("frame: resource '{}' is not declared", name));
  return static_cast<uint16_t>(resource - resources.data());
}

void Frame::State::addResource(FrameResource resource) {
  if (running) fail(fmt::format("frame: '{}' is declared while passes run", resource.name));
  if (resources.size() >= std::numeric_limits<uint16_t>::max()) fail("frame: too many resources");
  resource_of_name.emplace(resource.name, static_cast<uint16_t>(resources.size()));
  resources.push_back(std::move(resource));
  read_outside.push_back(0);
}

Frame::Frame() : state_(std::make_unique<State>()) {
  addTarget(std::string(kOutput), {.format = GL_RGBA8});
  keep(kOutput, true);
}

Frame::~Frame() = default;

void Frame::addTarget(std::string name, TargetDesc desc) {
  if (state_->find(name)) fail(fmt::format("frame: target '{}' is declared twice", name));
  if (desc.layers < 1 || desc.levels < 0 || (desc.fixed_size.x < 1) != (desc.fixed_size.y < 1))
    fail(fmt::format("frame: target '{}': {} layers, {} levels, size {}x{}", name, desc.layers,
                     desc.levels, desc.fixed_size.x, desc.fixed_size.y));
  FrameResource resource;
  resource.name = std::move(name);
  resource.target = true;
  resource.depth = gpu::isDepth(desc.format);
  resource.desc = desc;
  state_->addResource(std::move(resource));
}

void Frame::addExternal(std::string name) {
  if (const FrameResource* known = state_->find(name)) {
    if (known->target) fail(fmt::format("frame: '{}' is a target already", name));
    return;
  }
  FrameResource resource;
  resource.name = std::move(name);
  state_->addResource(std::move(resource));
}

namespace {

// What one use adds to the pass; ends the program if it cannot be.
void resolveUse(FramePass& pass, PassRules& rules, const Use& use, const FrameResource& resource,
                uint16_t number) {
  const std::string& name = pass.desc.name;
  auto refuse = [&](std::string_view why) {
    fail(fmt::format("frame: pass '{}' uses '{}': {}", name, use.resource, why));
  };
  for (const FrameUse& other : pass.uses) {
    if (other.resource != number) continue;
    const bool both_attached = isAttachment(other.access) && isAttachment(use.access);
    const bool drawn_and_read =
        (isWrite(other.access) && isAttachment(other.access) && use.access == Access::Sampled) ||
        (isWrite(use.access) && isAttachment(use.access) && other.access == Access::Sampled);
    if (other.access == use.access || both_attached) refuse("twice");
    if (drawn_and_read) refuse("it is sampled while it is drawn to");
  }
  if (isAttachment(use.access) && resource.target) {
    const bool depth_use = use.access == Access::Depth || use.access == Access::DepthTest;
    if (use.access != Access::Clear && depth_use != resource.depth)
      refuse(resource.depth ? "a depth format is no color attachment"
                            : "a color format is no depth attachment");
    if (resource.depth && pass.depth_tested) refuse("it has a depth attachment already");
    if (pass.attached && pass.fixed_size != resource.desc.fixed_size)
      refuse("its attachments differ in size");
    pass.attached = true;
    pass.fixed_size = resource.desc.fixed_size;
    pass.depth_tested |= resource.depth;
    pass.depth_written |= resource.depth && use.access != Access::DepthTest;
  } else if (isAttachment(use.access) && use.access != Access::Clear) {
    refuse("an external resource is no attachment");
  }
  pass.uses.push_back({.resource = number, .access = use.access});
  if (isWrite(use.access)) rules.written.push_back(number);
  if (isWrite(use.access) && use.access != Access::Clear) rules.content_written.push_back(number);
  if (isRead(use.access)) rules.read.push_back(number);
}

}  // namespace

void Frame::addPass(PassDesc desc) {
  State& s = *state_;
  if (s.running) fail(fmt::format("frame: pass '{}' is added while passes run", desc.name));
  if (desc.name.empty()) fail("frame: a pass has no name");
  for (const auto& other : s.passes)
    if (other->desc.name == desc.name)
      fail(fmt::format("frame: pass '{}' is added twice", desc.name));

  auto pass = std::make_unique<FramePass>();
  PassRules rules;
  pass->desc = std::move(desc);
  const PassDesc& d = pass->desc;
  for (const Use& use : d.uses) {
    const FrameResource* resource = s.find(use.resource);
    if (!resource)
      fail(fmt::format("frame: pass '{}' uses '{}', which is not declared", d.name, use.resource));
    resolveUse(*pass, rules, use, *resource, s.number(use.resource));
  }
  if (rules.written.empty())
    fail(fmt::format("frame: pass '{}' writes nothing, so it could never be on", d.name));
  const bool only_clears =
      std::all_of(pass->uses.begin(), pass->uses.end(), [&](const FrameUse& use) {
        return use.access == Access::Clear && s.resources[use.resource].target;
      });
  if (!d.run && !only_clears)
    fail(fmt::format("frame: pass '{}' has no code, and does more than clear targets", d.name));

  pass->reasons = {
      "on", fmt::format("needs {}", d.needs_text.empty() ? "a condition" : d.needs_text), "", ""};
  std::string& unread = pass->reasons[static_cast<size_t>(PassVerdict::NobodyReads)];
  for (uint16_t number : rules.written)
    unread +=
        fmt::format("{}{}", unread.empty() ? "nobody reads " : ", ", s.resources[number].name);
  for (const std::string& name : d.needs_content) {
    if (!s.find(name))
      fail(fmt::format("frame: pass '{}' needs content of '{}', which is not declared", d.name,
                       name));
    rules.content_needed.push_back(s.number(name));
    pass->reasons.push_back(fmt::format("nothing is drawn to {}", name));
  }
  pass->timer = s.timers.find(d.name);
  pass->reported.verdict = PassVerdict::NeedsUnmet;

  size_t at = s.passes.size();
  while (at > 0 && s.passes[at - 1]->desc.stage > d.stage) --at;
  const auto offset = static_cast<std::ptrdiff_t>(at);
  PassReport report;
  report.name = d.name;
  report.stage = d.stage;
  report.why = pass->reasons[static_cast<size_t>(PassVerdict::NeedsUnmet)];
  s.passes.insert(s.passes.begin() + offset, std::move(pass));
  s.rules.insert(s.rules.begin() + offset, std::move(rules));
  s.reports.insert(s.reports.begin() + offset, std::move(report));
}

void Frame::keep(std::string_view resource, bool kept) {
  state_->read_outside[state_->number(resource)] = kept || resource == kOutput;
}

void Frame::decide() {
  State& s = *state_;
  s.needs_met.resize(s.passes.size());
  for (size_t i = 0; i < s.passes.size(); ++i) {
    const auto& needs = s.passes[i]->desc.needs;
    s.needs_met[i] = !needs || needs();
  }
  s.activity.decide(s.rules, s.needs_met, s.read_outside);
  for (size_t i = 0; i < s.passes.size(); ++i) s.report(i);
}

bool Frame::isWanted(std::string_view resource, std::string_view besides) const {
  const State& s = *state_;
  const uint16_t number = s.number(resource);
  if (s.read_outside[number]) return true;
  for (size_t i = 0; i < s.passes.size(); ++i) {
    const PassDesc& desc = s.passes[i]->desc;
    const std::vector<uint16_t>& read = s.rules[i].read;
    if (desc.name == besides || std::find(read.begin(), read.end(), number) == read.end()) continue;
    if (!desc.needs || desc.needs()) return true;
  }
  return false;
}

void Frame::State::report(size_t index) {
  FramePass& pass = *passes[index];
  const PassDecision decision = activity.decisions()[index];
  if (decision.verdict == pass.reported.verdict && decision.resource == pass.reported.resource)
    return;
  pass.reported = decision;
  size_t reason = static_cast<size_t>(decision.verdict);
  if (decision.verdict == PassVerdict::ContentMissing) {
    const auto& needed = rules[index].content_needed;
    const auto found = std::find(needed.begin(), needed.end(), decision.resource);
    reason = 4 + static_cast<size_t>(found - needed.begin());
  }
  reports[index].on = decision.verdict == PassVerdict::On;
  reports[index].why = pass.reasons[reason];
}

bool Frame::hasTexture(std::string_view name) const {
  const FrameResource* resource = state_->find(name);
  return resource && resource->texture;
}

bool Frame::hasContent(std::string_view name) const {
  const FrameResource* resource = state_->find(name);
  if (!resource) return false;
  return state_->activity.hasContent(static_cast<size_t>(resource - state_->resources.data()));
}

bool Frame::isRead(std::string_view name) const {
  const FrameResource* resource = state_->find(name);
  if (!resource) return false;
  return state_->activity.isRead(static_cast<size_t>(resource - state_->resources.data()));
}

const std::vector<PassReport>& Frame::report() const {
  return state_->reports;
}

uint64_t Frame::runCount(std::string_view pass) const {
  for (const PassReport& report : state_->reports)
    if (report.name == pass) return report.runs;
  return 0;
}

void Frame::separatePasses(bool separate) {
  state_->separate = separate;
}

}  // namespace scree
