// What an App owns; only engine/app includes this.
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "engine/app/app.h"
#include "engine/app/statistics.h"
#include "engine/core/background.h"
#include "engine/platform/context.h"
#include "engine/platform/input.h"

namespace scree {

// In order of construction: GL objects of modules, frame and world die before the context.
struct App::State {
  AppOptions options;
  std::unique_ptr<Context> context;
  ActionMap actions;
  World world;
  Schedule schedule;
  Frame frame;
  std::vector<Gauge> gauges;
  uint64_t tick = 0;
  uint64_t rendered_frames = 0;
  std::atomic<bool> drawing = false;  // passes run beside ticks
  Background beside;                  // these ticks
};

}  // namespace scree
