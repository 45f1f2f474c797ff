// SPDX-License-Identifier: BSD-3-Clause

#include "calibration/pose_check.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace facetloc {

using namespace internal;

namespace {

using testing::HasSubstr;

/** A camera in the hand, which never moves evenly for long. */
Eigen::Isometry3d trueCamera(double t) {
  return Eigen::Translation3d(std::sin(1.3 * t), 0.3 * std::sin(2.1 * t), 1.5 * std::cos(0.8 * t)) *
         Eigen::Isometry3d(
             expSO3({0.4 * std::sin(1.7 * t), 0.9 * std::sin(0.9 * t + 1), 0.3 * std::sin(2.3 * t)}));
}

/** The motions between images, a little wrong; one in ten is of a wrong place. */
std::vector<SeenMotion> seenMotions(double scale = 1) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  std::vector<SeenMotion> motions;
  for (int i = 0; i < 40; ++i) {
    const double a = 1 + 0.4 * i, b = a + 0.3;
    Vector6d error;
    for (int k = 0; k < 6; ++k) error[k] = (k < 3 ? 0.3 * kDegree : 0.005) * normal(random);
    if (i % 10 == 9) error *= 200;
    SeenMotion motion{a, b, boxplus(trueCamera(a).inverse() * trueCamera(b), error)};
    motion.T_a_b.translation() *= scale;
    motions.push_back(motion);
  }
  return motions;
}

PoseCheck check(const std::function<Eigen::Isometry3d(double)>& poses, double scale = 1) {
  return checkPoses(seenMotions(scale), [&](double stamp) -> std::optional<Eigen::Isometry3d> {
    if (stamp < 0.9 || stamp > 18) return {};
    return poses(stamp);
  });
}

void expectNamed(const PoseCheck& found, const std::string& cause) {
  EXPECT_THAT(found.cause, HasSubstr(cause));
  EXPECT_EQ(found.cause.find(';'), std::string::npos) << found.cause;
  EXPECT_LT(found.mended.rotation_deg, 1);
  EXPECT_LT(found.mended.translation, 0.02);
  EXPECT_GT(found.as_given.rotation_deg + 50 * found.as_given.translation, 2);
}

TEST(PoseCheck, TruePosesAreFine) {
  const PoseCheck found = check(trueCamera);
  EXPECT_EQ(found.cause, "");
  EXPECT_TRUE(found.isKnown());
  EXPECT_FALSE(found.isBeyondSense());
  EXPECT_EQ(found.as_given.motions, 40u);
  EXPECT_THAT(found.as_given.toString(), HasSubstr("median of 40 motions"));
}

TEST(PoseCheck, ListsSingleMotionsThatAreOff) {
  const Findings found = check(trueCamera).list();
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].id, PoseCheck::kAccuracy);
  EXPECT_EQ(found[1].id, "poses.outliers");
  EXPECT_EQ(found[1].severity, Severity::note) << "images are wrong, too, now and then";
  EXPECT_THAT(found[1].words, HasSubstr("between 4.600 and 4.900 s"));
}

TEST(PoseCheck, AMedianAloneCallsNoPosesGood) {
  const PoseCheck found = check([](double t) {
    const double off = t > 12 ? 0.5 * std::sin(40 * t) : 0;
    return Eigen::Isometry3d(Eigen::Translation3d(off, off, 0) * trueCamera(t));
  });
  EXPECT_LT(found.as_given.translation, 0.02) << "of most motions";
  EXPECT_TRUE(found.hasTail());
  const Findings all = found.list();
  EXPECT_TRUE(std::any_of(all.begin(), all.end(), [](const Finding& finding) {
    return finding.id == "poses.outliers" && finding.severity == Severity::doubt;
  }));
}

TEST(PoseCheck, NoisyPosesAreNoWrongOnes) {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  const PoseCheck found = check([&](double t) {
    Vector6d error;
    for (int k = 0; k < 6; ++k) error[k] = (k < 3 ? kDegree : 0.03) * normal(random);
    return boxplus(trueCamera(t), error);
  });
  EXPECT_THAT(found.cause, HasSubstr("how accurate the poses are"));
  EXPECT_FALSE(found.wrong_convention);
  EXPECT_FALSE(found.isBeyondSense());
}

TEST(PoseCheck, NamesAWrongConvention) {
  const auto wFirst = [](double t) {
    Eigen::Isometry3d T = trueCamera(t);
    const Eigen::Quaterniond q(T.linear());
    T.linear() =
        Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y()).toRotationMatrix();  // quaternion in the order w x y z
    return T;
  };
  const auto ofAxes = [](const Eigen::Matrix3d& optical_in_axes) {
    return [optical_in_axes](double t) {
      Eigen::Isometry3d T = trueCamera(t);
      T.linear() = T.linear() * optical_in_axes.transpose();
      return T;
    };
  };
  Eigen::Matrix3d body;
  body.col(0) = -Eigen::Vector3d::UnitY();  // right is not left
  body.col(1) = -Eigen::Vector3d::UnitZ();  // down is not up
  body.col(2) = Eigen::Vector3d::UnitX();
  for (const auto& [poses, cause] :
       std::vector<std::pair<std::function<Eigen::Isometry3d(double)>, std::string>>{
           {wFirst, "w x y z"},
           {[](double t) { return trueCamera(t).inverse(); }, "inverted"},
           {ofAxes(body), "x forward"},
           {ofAxes(Eigen::Vector3d(1, -1, -1).asDiagonal()), "z backward"}}) {
    const PoseCheck found = check(poses);
    expectNamed(found, cause);
    EXPECT_TRUE(found.isBeyondSense());
  }
}

TEST(PoseCheck, NamesAnotherClock) {
  for (const double delay : {0.2, -0.35}) {
    const PoseCheck found = check([&](double t) { return trueCamera(t - delay); });
    expectNamed(found, delay > 0 ? "0.20 s later" : "0.35 s earlier");
    EXPECT_FALSE(found.wrong_convention);
  }
}

TEST(PoseCheck, FindsPosesWhoseClockMissesAllImages) {
  const auto shifted = [](double stamp) -> std::optional<Eigen::Isometry3d> {
    const double t = stamp - 0.2, step = std::round(t / 0.05) * 0.05;
    return std::abs(t - step) < 0.01 ? std::optional(trueCamera(t)) : std::nullopt;
  };
  expectNamed(checkPoses(seenMotions(), shifted), "0.20 s later");
}

TEST(PoseCheck, NamesAnotherScale) {
  expectNamed(check([](double t) {
                Eigen::Isometry3d T = trueCamera(t);
                T.translation() *= 1000;
                return T;
              }),
              "0.001 times as long");
  expectNamed(check(trueCamera, 0.2), "depth_scale");
}

TEST(PoseCheck, NamesAWrongFocalLength) {
  std::vector<SeenMotion> motions = seenMotions();
  for (SeenMotion& motion : motions) motion.T_a_b.linear() = expSO3(1.3 * logSO3(motion.T_a_b.linear()));
  const PoseCheck found =
      checkPoses(motions, [](double t) { return std::optional<Eigen::Isometry3d>(trueCamera(t)); });
  EXPECT_THAT(found.cause, HasSubstr("fx and fy"));
}

TEST(PoseCheck, WithoutMotionsOrPosesNothingIsKnown) {
  const auto nowhere = [](double) { return std::optional<Eigen::Isometry3d>(); };
  EXPECT_FALSE(checkPoses({}, nowhere).isKnown());
  EXPECT_FALSE(checkPoses(seenMotions(), nowhere).isKnown());
  EXPECT_FALSE(checkPoses(seenMotions(), nowhere).isBeyondSense());
  const auto still = [](double) { return std::optional<Eigen::Isometry3d>(Eigen::Isometry3d::Identity()); };
  EXPECT_TRUE(checkPoses(seenMotions(), still).isBeyondSense());
}

TEST(MotionRatio, IsKnownWithItsDeviation) {
  for (const double scale : {0.9, 1.12}) {
    const MotionRatio ratio = check(trueCamera, scale).distances;
    EXPECT_TRUE(ratio.differs()) << scale;
    EXPECT_NEAR(ratio.ratio, scale, 0.02);
    EXPECT_LT(ratio.std, 0.01);
  }
  const PoseCheck right = check(trueCamera);
  EXPECT_FALSE(right.distances.differs());
  EXPECT_FALSE(right.turns.differs());
  EXPECT_EQ(right.turns.certainAngleDeg(), 0);
  EXPECT_TRUE(right.ratiosInWords().empty());
}

TEST(MotionRatio, OfMotionsBelowTheNoiseIsNoFault) {
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  const PoseCheck found = check([&](double t) {  // errors as large as a motion
    Vector6d error;
    for (int k = 0; k < 6; ++k) error[k] = (k < 3 ? 2 * kDegree : 0.15) * normal(random);
    return boxplus(trueCamera(t), error);
  });
  EXPECT_FALSE(found.distances.differs());
  EXPECT_FALSE(found.turns.differs());
}

TEST(PoseCheck, NamesAScaleThatIsALittleOff) {
  const PoseCheck found = check(trueCamera, 1.25);
  EXPECT_THAT(found.cause, HasSubstr("depth_scale"));
  EXPECT_TRUE(found.isBeyondSense());
  const PoseCheck nearly = check(trueCamera, 1.08);
  EXPECT_THAT(nearly.cause, HasSubstr("1.07"));
  EXPECT_FALSE(nearly.isBeyondSense());
}

TEST(PoseCheck, NamesMirroredImages) {
  std::vector<SeenMotion> motions = seenMotions();
  const Eigen::Matrix3d S = Eigen::Vector3d(-1, 1, 1).asDiagonal();
  for (SeenMotion& motion : motions) {
    motion.T_a_b.linear() = S * motion.T_a_b.linear() * S;
    motion.T_a_b.translation() = S * motion.T_a_b.translation();
  }
  const PoseCheck found = checkPoses(motions, [](double stamp) { return std::optional(trueCamera(stamp)); });
  EXPECT_THAT(found.cause, HasSubstr("mirrored, left to right"));
  EXPECT_TRUE(found.isBeyondSense());
}

TEST(PoseCheck, NamesAnotherAxis) {
  const PoseCheck found = check([](double t) {
    Eigen::Isometry3d T = trueCamera(t);
    T.linear() = T.linear() * expSO3({3 * kDegree, 0, 0});
    return T;
  });
  EXPECT_THAT(found.cause, HasSubstr("about axes that are"));
  EXPECT_FALSE(found.isBeyondSense());
}

}  // namespace
}  // namespace facetloc
