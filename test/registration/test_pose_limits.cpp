// SPDX-License-Identifier: BSD-3-Clause
#include "nearby/hypothesis_ranking.h"

#include <facetloc/registration/registration_params.h>

#include <gmock/gmock.h>

namespace facetloc {
namespace {

using testing::HasSubstr;

/** Standard deviations of one rotation and one translation; the others are small. */
Matrix6d covariance(double rotation_deg, double translation) {
  Vector6d std;
  std << rotation_deg * kDegree, 1e-3, 1e-3, translation, 1e-3, 1e-3;
  return std.cwiseAbs2().asDiagonal();
}

Localization answerWith(double probability, const Matrix6d& P) {
  Localization answer;
  answer.hypotheses.resize(1);
  answer.hypotheses[0].probability = probability, answer.hypotheses[0].T_m_c.P = P;
  internal::concludePose({}, answer);
  return answer;
}

TEST(PoseLimits, AreTwoStandardDeviations) {
  const PoseLimits limits;
  EXPECT_TRUE(limits.hold(covariance(2.49, 0.149)));
  EXPECT_FALSE(limits.hold(covariance(2.51, 0.149)));
  EXPECT_FALSE(limits.hold(covariance(2.49, 0.151)));
}

TEST(PoseLimits, NameTheMotionThatIsOpen) {
  const PoseLimits limits;
  EXPECT_EQ(limits.whyNotFixed(covariance(1, 1), Eigen::Matrix3d::Identity()),
            "nothing in view fixes translation along (1.00, 0.00, 0.00)");
  EXPECT_THAT(limits.whyNotFixed(covariance(20, 0.1), Eigen::Matrix3d::Identity()),
              HasSubstr("rotation about (1.00, 0.00, 0.00)"));
}

/** The uncertainty of the prior is no pose that one may act on, however probable its place. */
TEST(PoseLimits, BoundWhatIsSure) {
  const Localization fixed = answerWith(0.99, covariance(1, 0.05)),
                     open = answerWith(0.99, covariance(20, 1)),
                     improbable = answerWith(0.6, covariance(1, 0.05));
  EXPECT_EQ(fixed.state, AnswerState::sure);
  EXPECT_TRUE(fixed.reason.empty());
  EXPECT_EQ(open.state, AnswerState::doubtful);
  EXPECT_THAT(open.reason, HasSubstr("nothing in view fixes"));
  EXPECT_EQ(improbable.state, AnswerState::doubtful);
}

}  // namespace
}  // namespace facetloc
