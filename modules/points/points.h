// Grains smaller than a pixel: splatted by compute, the foremost by depth, then all that are not hidden behind it
// listed and summed up, so that a far heap neither shimmers nor darkens; then one pass writes the G-buffer.
//
// Equations: shaders/shared/points.h (sums in whole numbers, so that the picture does not depend on the order of
// the grains), bed.h (which sides are seen, where shadows fall), spread.h (light). In: what modules/lod routed to
// points. Out: the G-buffer.
// Cost: one test a run of 64, two visits of each point that is drawn in runs that are not hidden, 28 bytes a pixel; see
// README.md.
#pragma once

namespace scree {

class App;

// Registers points.give_back (Prepare), points.depth, points.list, points.sum, points.count and points.resolve
// (GeometryLate). Needs addLod.
void addPoints(App& app);

}  // namespace scree
