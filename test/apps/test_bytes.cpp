// SPDX-License-Identifier: BSD-3-Clause
#include "batch/bytes.h"
#include "example_scene.h"

#include <facetloc/io/map_database.h>
#include <facetloc/segmentation/view_builder.h>
#include <facetloc/testing/matchers.h>
#include <facetloc/testing/random_segments.h>

namespace facetloc::test {
namespace {

View exampleView() {
  Camera camera;
  camera.noise.inverse_depth_std = 0.01 / 3;
  const DepthImage image = ExampleScene().see("corner", ExampleScene::pose(0, 0, 10)).depth;
  return ViewBuilder(camera).build(image, Gravity{{0, 0.6, 0.8}, 0.01});
}

/** The bytes hold every number: two values of equal bytes are equal. */
template <class T>
void expectSurvives(const T& value) {
  const std::string bytes = toBytes(value);
  EXPECT_EQ(toBytes(fromBytes<T>(bytes)), bytes);
}

TEST(Bytes, LocalModelsSurvive) {
  const LocalModel model{"a model", 1.0 / 3, Eigen::Isometry3d(Eigen::Translation3d(1, 2, 3))};
  const View sent = exampleView();
  const PackedModel sent_model = packed(model, sent);
  expectSurvives(sent_model);
  expectSurvives(PackedModel());
  const auto again = fromBytes<PackedModel>(toBytes(sent_model));
  EXPECT_EQ(again.model.name, model.name);
  EXPECT_EQ(again.model.stamp, model.stamp);
  EXPECT_EQ(again.model.T_w_m->matrix(), model.T_w_m->matrix());
  const View& received = again.view;
  ASSERT_FALSE(sent.segments.empty());
  EXPECT_EQ(received.intrinsics, sent.intrinsics);
  EXPECT_EQ(received.depth.camera, sent.depth.camera);
  EXPECT_EQ(received.noise(), sent.noise());
  ASSERT_TRUE(received.gravity);
  EXPECT_EQ(received.gravity->down, sent.gravity->down);
  EXPECT_EQ(received.gravity->std, sent.gravity->std);
  ASSERT_EQ(received.segments.size(), sent.segments.size());
  for (std::size_t i = 0; i < sent.segments.size(); ++i)
    EXPECT_TRUE(sameNumbers(received.segments[i], sent.segments[i])) << i;
  EXPECT_EQ(again.depth, sent_model.depth);
}

TEST(Bytes, DistortionsSurvive) {
  DepthDistortion::Values values;
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = 1.0 / (3.0 + static_cast<double>(i));
  const DepthDistortion distortion(DepthDistortion::extentOf(kinectIntrinsics()), values);
  const auto [images, again] = fromBytes<ModelsOrder>(toBytes(ModelsOrder{{3, 5}, distortion}));
  EXPECT_THAT(images, ElementsAre(3u, 5u));
  ASSERT_TRUE(again);
  EXPECT_EQ(again->extent().min(), distortion.extent().min());
  EXPECT_EQ(again->extent().max(), distortion.extent().max());
  EXPECT_EQ(again->values(), values);
  EXPECT_FALSE(fromBytes<ModelsOrder>(toBytes(ModelsOrder())).second);
}

TEST(Bytes, ResultsSurvive) {
  FrameResult result;
  result.stamp = 1.0 / 3;
  result.timing = {"frame", 1, 2, 3, 4};
  result.rows.resize(2);
  result.rows[1].reason = "a \"reason\"\nof two lines";
  result.rows[1].T_w_c = Eigen::Isometry3d::Identity();
  result.rows[1].part = "a part";
  expectSurvives(LocalizedImage{result, {1.0 / 3, 60, 2}});
  const auto [again, traits] = fromBytes<LocalizedImage>(toBytes(LocalizedImage{result, {1.0 / 3, 60, 2}}));
  EXPECT_EQ(again.timing.frame, "frame");
  EXPECT_EQ(again.rows.at(1).reason, result.rows[1].reason);
  EXPECT_EQ(again.rows.at(1).part, "a part");
  EXPECT_EQ(traits.noise, 1.0 / 3);
}

TEST(Bytes, TornOnesAreRefused) {
  const std::string bytes = toBytes(packed({"a", 1}, exampleView()));
  for (std::size_t n = 0; n < bytes.size(); n += 97)
    EXPECT_THROW(fromBytes<PackedModel>(bytes.substr(0, n)), std::exception) << n;
  EXPECT_THROW(fromBytes<PackedModel>(bytes + "x"), std::runtime_error);
  EXPECT_THROW(fromBytes<std::vector<std::string>>(std::string(8, '\xFF')), std::runtime_error);
}

TEST(Bytes, DistortionsOverNothingAreRefused) {
  std::string bytes = toBytes(ModelsOrder{{}, DepthDistortion()});
  constexpr std::size_t kLow = 2 * sizeof(std::size_t),
                        kCorner = 2 * sizeof(double);                   // behind two counts
  bytes.replace(kLow, kCorner, bytes.substr(kLow + kCorner, kCorner));  // the lower corner is the upper one
  EXPECT_THROW(fromBytes<ModelsOrder>(bytes), std::runtime_error);
}

}  // namespace
}  // namespace facetloc::test
