// What runs for which scene, and what it costs when there is nothing to do.
#include "engine/gpu/counters.h"
#include "tests/deferred/studio.h"

namespace scree::test {
namespace {

using Names = std::vector<std::string>;

class DeferredPasses : public GlTest {};

TEST_F(DeferredPasses, EmptySceneClearsShowsTheSkyAndPresents) {
  Studio studio;
  for (const std::string_view kept : {kGbufferId, kRadiance}) studio.app.frame().keep(kept, false);
  studio.look({0, 1, 5}, {0, 1, 0});
  const gpu::Counters before = gpu::counters();
  studio.render();
  const gpu::Counters first = gpu::counters() - before;
  EXPECT_EQ(studio.passes(), (Names{"deferred.clear", "deferred.sky", "deferred.present"}));
  EXPECT_EQ(first.programs, 2u);  // sky and present
  EXPECT_EQ(first.draws, 2u);
  EXPECT_EQ(first.dispatches, 0u);
  EXPECT_EQ(first.textures, 3u);  // depth, radiance, output
  EXPECT_EQ(first.texture_bytes, (4u + 8 + 4) * 160 * 120);
  EXPECT_EQ(first.buffers, 2u);  // view, blocks of the frame
  for (const std::string_view target : {kGbufferAlbedo, kGbufferNormal, kGbufferEmissive, kGbufferMotion,
                                        kGbufferId, kShadowMap, kTruth})
    EXPECT_FALSE(studio.app.frame().hasTexture(target)) << target;

  const gpu::Counters warm = gpu::counters();
  studio.render();
  const gpu::Counters second = gpu::counters() - warm;
  EXPECT_EQ(second.programs + second.textures + second.buffers + second.framebuffers, 0u);
  EXPECT_EQ(second.draws, 2u);
  EXPECT_LE(second.bytes_uploaded, 1024u);
}

TEST_F(DeferredPasses, RunAsTheSceneNeedsThem) {
  Studio studio;
  studio.look({0, 1, 5}, {0, 1, 0});
  const Entity ball = studio.put(studio.mesh(sphereMesh(8, 16)), 0, {0, 1, 0}, vec3(0.5f));
  studio.render();
  EXPECT_EQ(studio.passes(), (Names{"deferred.clear", "deferred.opaque", "deferred.light", "deferred.sky",
                                    "deferred.present"}));
  const Entity sun = studio.sun({1, 1, 1});
  studio.render();
  EXPECT_EQ(studio.passes(), (Names{"deferred.clear", "deferred.shadow", "deferred.opaque", "deferred.light",
                                    "deferred.sky", "deferred.present"}));
  studio.world.remove<CastsShadow>(ball);
  studio.render();
  EXPECT_EQ(studio.passes(), (Names{"deferred.clear", "deferred.opaque", "deferred.light", "deferred.sky",
                                    "deferred.present"}));
  studio.render(2);
  EXPECT_EQ(studio.passes(), (Names{"deferred.clear", "deferred.opaque", "deferred.light", "deferred.sky",
                                    "deferred.accumulate", "deferred.present"}));
  // Behind the camera: nothing is drawn, so nothing is lit.
  *studio.world.find<Transform>(ball) = {dvec3(0, 1, 50), quat(1, 0, 0, 0), vec3(0.5f)};
  *studio.world.find<PreviousTransform>(ball) = {dvec3(0, 1, 50), quat(1, 0, 0, 0), vec3(0.5f)};
  studio.render();
  EXPECT_EQ(studio.passes(), (Names{"deferred.clear", "deferred.sky", "deferred.present"}));
  studio.world.destroy(sun);
  studio.world.destroy(ball);
  studio.render();
  EXPECT_EQ(studio.passes(), (Names{"deferred.clear", "deferred.sky", "deferred.present"}));
}

// Radiance that only the display would read is neither written nor made.
TEST_F(DeferredPasses, ShowAtOnceWhatNobodyElseReads) {
  Studio studio;
  studio.app.frame().keep(kRadiance, false);
  studio.look({0, 1, 5}, {0, 1, 0});
  const Entity ball = studio.put(studio.mesh(sphereMesh(8, 16)), 0, {0, 1, 0}, vec3(0.5f));
  studio.render();
  EXPECT_EQ(studio.passes(), (Names{"deferred.clear", "deferred.opaque", "deferred.display_light",
                                    "deferred.display_sky"}));
  EXPECT_FALSE(studio.app.frame().hasTexture(kRadiance));
  EXPECT_EQ(studio.app.frame().runCount("deferred.present"), 0u);
  studio.render(2);
  EXPECT_EQ(studio.passes(), (Names{"deferred.clear", "deferred.opaque", "deferred.light", "deferred.sky",
                                    "deferred.accumulate", "deferred.present"}));
  studio.render();
  EXPECT_EQ(studio.passes(), (Names{"deferred.clear", "deferred.opaque", "deferred.display_light",
                                    "deferred.display_sky"}));
  studio.world.destroy(ball);
  studio.render();
  EXPECT_EQ(studio.passes(), (Names{"deferred.clear", "deferred.sky", "deferred.present"}));
}

// The table of the sky's reflection is dear: whichever pass shades, it is the same.
TEST_F(DeferredPasses, ShareTheLobeTable) {
  Studio studio;
  studio.look({0, 1, 5}, {0, 1, 0});
  studio.put(studio.mesh(sphereMesh(8, 16)), 0, {0, 1, 0}, vec3(0.5f));
  studio.render();
  studio.app.frame().keep(kRadiance, false);
  const uint64_t textures = gpu::counters().textures;
  studio.render();
  EXPECT_EQ(studio.app.frame().runCount("deferred.light"), 1u);
  EXPECT_EQ(studio.app.frame().runCount("deferred.display_light"), 1u);
  EXPECT_EQ(gpu::counters().textures, textures);
}

}  // namespace
}  // namespace scree::test
