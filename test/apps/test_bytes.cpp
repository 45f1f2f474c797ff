// SPDX-License-Identifier: BSD-3-Clause
#include "example_scene.h"
#include "tools/bytes.h"
#include "tools/sharded_localization.h"

#include <facetloc/io/map_database.h>
#include <facetloc/io/results.h>
#include <facetloc/registration/hypothesis.h>
#include <facetloc/registration/place_index.h>
#include <facetloc/segmentation/view_builder.h>

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

namespace facetloc {
namespace {

using test::ExampleScene;

View exampleView() {
  return ViewBuilder().build(ExampleScene().see("corner", ExampleScene::pose(0, 0, 10)).depth);
}

Hypothesis exampleHypothesis() {
  Hypothesis h;
  h.model = 7;
  h.T_m_c.T =
      Eigen::AngleAxisd(0.1, Eigen::Vector3d(1, 2, 3).normalized()) * Eigen::Translation3d(1, 2, 1.0 / 7);
  h.T_m_c.P = Matrix6d::Identity() / 3;
  h.pairs = {{1, 2, 1.0 / 3}, {4, 5, std::numeric_limits<double>::infinity()}};
  h.depth_assisted = true;
  h.consensus = -1e-300;
  h.free_space = -0.0;
  h.evidence = std::numeric_limits<double>::denorm_min();
  h.score = std::numeric_limits<double>::quiet_NaN();
  h.probability = 1.0 / 9;
  h.found_by = {2, 7};
  return h;
}

/** The bytes hold every number: two values of equal bytes are equal. */
template <class T>
void expectSurvives(const T& value) {
  const std::string bytes = toBytes(value);
  EXPECT_EQ(toBytes(fromBytes<T>(bytes)), bytes);
}

TEST(Bytes, ViewsSurvive) {
  const View view = exampleView();
  ASSERT_FALSE(view.segments.empty());
  ASSERT_FALSE(view.depth.empty());
  expectSurvives(std::optional<View>(view));
  expectSurvives(std::optional<View>(View()));
  const auto again = fromBytes<std::optional<View>>(toBytes(std::optional<View>(view)));
  ASSERT_TRUE(again);
  EXPECT_EQ(again->camera, view.camera);
  ASSERT_EQ(again->segments.size(), view.segments.size());
  for (std::size_t i = 0; i < view.segments.size(); ++i) {
    const Segment &a = again->segments[i], &b = view.segments[i];
    EXPECT_EQ(a.R, b.R);
    EXPECT_EQ(a.t, b.t);
    EXPECT_EQ(a.Sigma_q, b.Sigma_q);
    EXPECT_EQ(a.lambda, b.lambda);
    EXPECT_EQ(a.num_points, b.num_points);
    EXPECT_TRUE(std::equal(a.hull.begin(), a.hull.end(), b.hull.begin(), b.hull.end()));
  }
  EXPECT_EQ(again->depth.camera, view.depth.camera);
  EXPECT_EQ(again->depth.inverse_depth, view.depth.inverse_depth);
  EXPECT_EQ(again->depth.lowest, view.depth.lowest);
  EXPECT_EQ(again->depth.highest, view.depth.highest);
  EXPECT_FALSE(fromBytes<std::optional<View>>(toBytes(std::optional<View>())));
}

TEST(Bytes, LocalModelsSurvive) {
  const LocalModel model{"a model", 1.0 / 3, Eigen::Isometry3d(Eigen::Translation3d(1, 2, 3)), exampleView()};
  const std::vector<PackedModel> models = {packed(model), {}};
  expectSurvives(models);
  const auto again = fromBytes<std::vector<PackedModel>>(toBytes(models));
  ASSERT_EQ(again.size(), 2u);
  EXPECT_EQ(again[0].model.name, model.name);
  EXPECT_EQ(again[0].model.stamp, model.stamp);
  EXPECT_EQ(again[0].model.T_w_m->matrix(), model.T_w_m->matrix());
  EXPECT_EQ(again[0].model.view.depth.camera, model.view.depth.camera);
  EXPECT_EQ(again[0].depth, models[0].depth);
  EXPECT_FALSE(again[1].model.T_w_m);
}

TEST(Bytes, HypothesesSurvive) {
  Hypothesis posed = exampleHypothesis();
  posed.T_w_c = posed.T_m_c.T.inverse();
  const ShardedLocalization::Share share{{exampleHypothesis(), posed}, "a model cannot be read"};
  expectSurvives(share);
  const auto copy = fromBytes<ShardedLocalization::Share>(toBytes(share));
  EXPECT_EQ(copy.failure, share.failure);
  const Hypothesis& h = copy.hypotheses.at(1);
  EXPECT_EQ(h.model, posed.model);
  EXPECT_EQ(h.T_m_c.T.matrix(), posed.T_m_c.T.matrix());
  EXPECT_EQ(h.T_m_c.P, posed.T_m_c.P);
  EXPECT_EQ(h.T_w_c->matrix(), posed.T_w_c->matrix());
  ASSERT_EQ(h.pairs.size(), 2u);
  EXPECT_EQ(h.pairs[1].model, 5);
  EXPECT_TRUE(h.depth_assisted);
  EXPECT_EQ(h.consensus, posed.consensus);
  EXPECT_TRUE(std::signbit(h.free_space));
  EXPECT_EQ(h.evidence, posed.evidence);
  EXPECT_TRUE(std::isnan(h.score));
  EXPECT_EQ(h.probability, posed.probability);
  EXPECT_EQ(h.found_by, posed.found_by);
}

TEST(Bytes, DistortionsSurvive) {
  DepthDistortion::Values values;
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = 1.0 / (3.0 + static_cast<double>(i));
  const std::optional<DepthDistortion> distortion(
      DepthDistortion(DepthDistortion::extentOf(kinectIntrinsics()), values));
  const auto again = fromBytes<std::optional<DepthDistortion>>(toBytes(distortion));
  ASSERT_TRUE(again);
  EXPECT_EQ(again->extent().min(), distortion->extent().min());
  EXPECT_EQ(again->extent().max(), distortion->extent().max());
  EXPECT_EQ(again->values(), values);
  EXPECT_FALSE(fromBytes<std::optional<DepthDistortion>>(toBytes(std::optional<DepthDistortion>())));
}

TEST(Bytes, CandidatesSurvive) {
  const Eigen::Isometry3d start(Eigen::Translation3d(1.0 / 3, -0.0, 2));
  const auto again =
      fromBytes<std::vector<Candidate>>(toBytes(std::vector<Candidate>{{7, 3, start}, {8, 0, {}}}));
  ASSERT_EQ(again.size(), 2u);
  EXPECT_EQ(again[0].model, 7);
  EXPECT_EQ(again[0].rank, 3);
  EXPECT_EQ(again[0].start->matrix(), start.matrix());
  EXPECT_EQ(again[1].model, 8);
  EXPECT_FALSE(again[1].start);
}

TEST(Bytes, ResultsSurvive) {
  FrameResult result;
  result.stamp = 1.0 / 3;
  result.timing = {"frame", 1, 2, 3, 4};
  result.rows.resize(2);
  result.rows[1].reason = "a \"reason\"\nof two lines";
  result.rows[1].T_w_c = Eigen::Isometry3d::Identity();
  expectSurvives(std::vector<FrameResult>{result, {}});
  const auto again = fromBytes<std::vector<FrameResult>>(toBytes(std::vector<FrameResult>{result}));
  EXPECT_EQ(again.at(0).timing.frame, "frame");
  EXPECT_EQ(again.at(0).rows.at(1).reason, result.rows[1].reason);
}

TEST(Bytes, TornOnesAreRefused) {
  const std::string bytes = toBytes(std::optional<View>(exampleView()));
  for (std::size_t n = 0; n < bytes.size(); n += 97)
    EXPECT_THROW(fromBytes<std::optional<View>>(bytes.substr(0, n)), std::exception) << n;
  EXPECT_THROW(fromBytes<std::optional<View>>(bytes + "x"), std::runtime_error);
  EXPECT_THROW(fromBytes<std::vector<std::string>>(std::string(8, '\xFF')), std::runtime_error);
}

}  // namespace
}  // namespace facetloc
