// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/ekf_pose_update.h"

#include <facetloc/features/pose.h>
#include <facetloc/features/segment_estimation.h>
#include <facetloc/registration/pose_prior.h>
#include <facetloc/testing/plane_residual.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/random_segments.h>
#include <facetloc/testing/synthetic_depth.h>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

namespace facetloc {
namespace {

using namespace internal;
using test::disturbed, test::gaussian, test::IsPositiveSemidefinite, test::MatrixNear, test::PoseNear,
    test::randomDirection, test::Rng, test::uniform;

constexpr double kGate = chiSquareQuantile(3, 0.99);

EkfParams ungated(int iterations = EkfParams{}.iterations) {
  EkfParams p;
  p.iterations = iterations;
  p.gate = std::numeric_limits<double>::max();
  return p;
}

// The prior of the paper: a robot with a camera that looks forward, slightly down.
PoseWithCovariance paperPrior() {
  return {Eigen::Isometry3d::Identity(), posePrior(CameraMounting{0.98, 10})};
}

PoseWithCovariance narrowPrior(Rng& rng) {
  PoseWithCovariance prior;
  prior.T = test::randomPose(rng, 0.5, 1);
  Vector6d std;
  std << 0.02, 0.03, 0.01, 0.05, 0.04, 0.06;
  prior.P = test::randomCovariance<6>(rng, std);
  return prior;
}

// Three nearly orthogonal surfaces about 2 m around a local model.
std::array<Segment, 3> corner(Rng& rng) {
  std::array<Segment, 3> model;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d n = expSO3(0.1 * gaussian<3>(rng)) * Eigen::Vector3d::Unit(k);
    const Eigen::Vector3d centre = test::uniformVector(rng, 1) + 2 * Eigen::Vector3d::Unit(k);
    model[k] = test::rectangle(centre, n, 1, 0.6, uniform(rng, -3, 3), 0.01, 0.01);
  }
  return model;
}

// A true surface as the camera at T_m_c measures it: another part of it, with an error drawn from Sigma_q.
Segment seen(const Segment& truth, const Eigen::Isometry3d& T_m_c, const Eigen::Matrix3d& Sigma_q, Rng& rng) {
  Segment part = test::anotherPart(rng, truth, 0.3);
  part.Sigma_q = Sigma_q;
  return transformed(disturbed(part, gaussian<3>(rng, Sigma_q)), T_m_c.inverse());
}

Segment measured(const Segment& truth, Rng& rng) { return disturbed(truth, gaussian<3>(rng, truth.Sigma_q)); }

// A random surface as both views measure it, from a pose drawn from the prior.
std::pair<Segment, Segment> randomPair(Rng& rng, const PoseWithCovariance& prior) {
  const Segment surface = test::randomSegment(rng);
  const Eigen::Isometry3d truth = boxplus(prior.T, gaussian<6>(rng, prior.P));
  const Segment scene = seen(surface, truth, surface.Sigma_q, rng);
  return {scene, measured(surface, rng)};
}

double nees(const PoseWithCovariance& estimate, const Eigen::Isometry3d& truth) {
  const Vector6d e = boxminus(truth, estimate.T);
  return e.dot(estimate.P.llt().solve(e));
}

struct Consistency {
  double mean_nees = 0;
  std::array<double, 3> accepted{};  // share of the correct first, second, third pairs within the gate
};

// The experiment of METHOD 5.1 with given true surfaces per trial.
template <class Surfaces>
Consistency experiment(const EkfParams& params, int trials, const Surfaces& surfaces) {
  Rng rng(5);
  const PoseWithCovariance prior = paperPrior();
  Consistency result;
  std::array<int, 3> tried{};
  int converged = 0;
  for (int i = 0; i < trials; ++i) {
    const Eigen::Isometry3d truth = boxplus(prior.T, gaussian<6>(rng, prior.P));
    PoseWithCovariance pose = prior;
    bool all = true;
    const std::array<Segment, 3> corner_segments = surfaces(rng);
    for (int k = 0; k < 3 && all; ++k) {
      const Segment& surface = corner_segments[k];
      ++tried[k];
      const EkfUpdate u =
          ekfPoseUpdate(seen(surface, truth, surface.Sigma_q, rng), measured(surface, rng), pose, params);
      all = u.accepted;
      result.accepted[k] += u.accepted && u.cost <= kGate;
      if (all) pose = u.pose;
    }
    if (!all) continue;
    ++converged;
    result.mean_nees += nees(pose, truth);
  }
  result.mean_nees /= converged;
  for (int k = 0; k < 3; ++k) result.accepted[k] /= tried[k];
  return result;
}

void expectConsistent(const Consistency& c) {
  EXPECT_GE(c.mean_nees, 5.5);  // ideal: 6
  EXPECT_LE(c.mean_nees, 7.0);
  for (const double share : c.accepted) {
    EXPECT_GE(share, 0.98);  // nominal: 0.99
    EXPECT_LE(share, 0.995);
  }
}

TEST(EkfPoseUpdate, ErrorsOfTheIteratedFilterAreAsLargeAsItSays) {
  expectConsistent(experiment(ungated(), 3000, corner));
}

TEST(EkfPoseUpdate, TheFilterOfOneIterationIsOverconfident) {
  EXPECT_GT(experiment(ungated(1), 500, corner).mean_nees, 50);  // METHOD 5.1
}

TEST(EkfPoseUpdate, ASecondLinearisationTakesMostOfTheOverconfidence) {
  const double one = experiment(ungated(1), 3000, corner).mean_nees,
               two = experiment(ungated(2), 3000, corner).mean_nees;
  EXPECT_LT(two, one / 5);
  EXPECT_GT(two, 10);  // but not all of it: METHOD 5.1
}

TEST(EkfPoseUpdate, IsConsistentWithTheUncertaintyOfRealSegments) {
  // Surfaces and Sigma_q of rendered corners of rooms.
  std::vector<std::array<Segment, 3>> corners;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Isometry3d T =
        test::lookingAlong({1.2 + 0.2 * i, 1.9 - 0.1 * i, 1.3}, {1, 0.7 + 0.1 * i, -0.6 + 0.03 * i});
    const test::Rendering r = test::render(test::box({0, 0, 0}, {4, 4, 3}), test::smallCamera(), T);
    const std::vector<Segment> s = estimateSegments(r.image, r.labels, {}, {});
    ASSERT_GE(s.size(), 3u);
    corners.push_back({s[0], s[1], s[2]});
  }
  expectConsistent(
      experiment(ungated(), 3000, [&corners](Rng& rng) { return corners[rng() % corners.size()]; }));
}

TEST(EkfPoseUpdate, OneIterationIsTheImplicitFilterOfTheTextbook) {
  Rng rng(6);
  for (int i = 0; i < 200; ++i) {
    const PoseWithCovariance prior = narrowPrior(rng);
    const auto [scene, model] = randomPair(rng, prior);
    const EkfUpdate u = ekfPoseUpdate(scene, model, prior, ungated(1));
    ASSERT_TRUE(u.accepted);
    // Ayache & Faugeras: linearise 0 = h(w, q, q') about the prior mean and zero disturbances.
    PlaneMeasurement m;
    ASSERT_TRUE(measurePlane(scene, model, prior.T, 0, m));
    const Eigen::Matrix<double, 6, 3> K =
        prior.P * m.H.transpose() * (m.H * prior.P * m.H.transpose() + m.W).inverse();
    const Vector6d dw = -K * m.h;
    const Matrix6d IKH = Matrix6d::Identity() - K * m.H;
    Matrix6d reset = Matrix6d::Identity();
    reset.topLeftCorner<3, 3>() = leftJacobianSO3(dw.head<3>());
    const Matrix6d P =
        reset * (IKH * prior.P * IKH.transpose() + K * m.W * K.transpose()) * reset.transpose();
    EXPECT_THAT(u.pose.T, PoseNear(boxplus(prior.T, dw), 1e-12, 1e-10));
    EXPECT_THAT(u.pose.P, MatrixNear(P, 1e-12));
  }
}

// The same update from the residual alone: derivatives by differences, solved in the space of the pose.
class NumericUpdate {
public:
  NumericUpdate(const Segment& scene, const Segment& model, const PoseWithCovariance& prior)
      : scene_(scene), model_(model), prior_(prior) {}

  PoseWithCovariance after(int linearisations) {
    Vector6d e = Vector6d::Zero();
    for (int i = 0; i < linearisations; ++i) e = next(e);
    PoseWithCovariance posterior;
    Matrix6d reset = Matrix6d::Identity();
    reset.topLeftCorner<3, 3>() = leftJacobianSO3(e.head<3>());
    posterior.T = boxplus(prior_.T, e);
    posterior.P = reset * information_.inverse() * reset.transpose();
    cost_ = e.dot(prior_.P.inverse() * e) + left_.dot(W_.inverse() * left_);
    return posterior;
  }
  double cost() const { return cost_; }  // cost at the last linearisation

private:
  Eigen::Vector3d residual(const Vector6d& e, const Eigen::Vector3d& q, const Eigen::Vector3d& q_model) {
    return test::residualOfThePaper(scene_, model_, boxplus(prior_.T, e), q, q_model);
  }

  // The minimum over e' of e'^T P^-1 e' + h^T W^-1 h, with h linear about the displacement e.
  Vector6d next(const Vector6d& e) {
    constexpr double kStep = 1e-5;
    const Eigen::Vector3d zero = Eigen::Vector3d::Zero(), h = residual(e, zero, zero);
    Matrix36d H;
    Eigen::Matrix3d E, E_model;
    for (int k = 0; k < 6; ++k) {
      const Vector6d d = kStep * Vector6d::Unit(k);
      H.col(k) = (residual(e + d, zero, zero) - residual(e - d, zero, zero)) / (2 * kStep);
    }
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d d = kStep * Eigen::Vector3d::Unit(k);
      E.col(k) = (residual(e, d, zero) - residual(e, -d, zero)) / (2 * kStep);
      E_model.col(k) = (residual(e, zero, d) - residual(e, zero, -d)) / (2 * kStep);
    }
    W_ = E * scene_.Sigma_q * E.transpose() + E_model * model_.Sigma_q * E_model.transpose();
    information_ = prior_.P.inverse() + H.transpose() * W_.inverse() * H;
    const Vector6d moved = information_.ldlt().solve(H.transpose() * W_.inverse() * (H * e - h));
    left_ = h + H * (moved - e);
    return moved;
  }

  const Segment &scene_, &model_;
  const PoseWithCovariance& prior_;
  Eigen::Matrix3d W_;
  Matrix6d information_;
  Eigen::Vector3d left_;
  double cost_ = 0;
};

TEST(EkfPoseUpdate, FewLinearisationsAreTakenOnTrust) {
  Rng rng(21);
  int unsettled = 0;
  for (int i = 0; i < 200; ++i) {
    PoseWithCovariance prior = narrowPrior(rng);
    prior.P *= 100;  // standard deviations of up to 17 deg and 0.6 m
    const Segment surface = test::randomSegment(rng);
    const Eigen::Isometry3d truth = boxplus(prior.T, 0.5 * gaussian<6>(rng, prior.P));
    const Segment scene = seen(surface, truth, surface.Sigma_q, rng), model = measured(surface, rng);
    for (const int n : {1, 2, 3}) {
      EkfParams params = ungated(n);
      params.min_cosine = 0;
      const EkfUpdate u = ekfPoseUpdate(scene, model, prior, params);
      ASSERT_TRUE(u.accepted) << n << " linearisations";
      NumericUpdate numeric(scene, model, prior);
      const PoseWithCovariance expected = numeric.after(n);
      EXPECT_THAT(u.pose.T, PoseNear(expected.T, 1e-6, 1e-4)) << n;
      EXPECT_THAT(u.pose.P, MatrixNear(expected.P, 1e-6)) << n;
      EXPECT_NEAR(u.cost, numeric.cost(), 1e-4 * (1 + u.cost)) << n;
    }
    NumericUpdate numeric(scene, model, prior);
    unsettled += boxminus(numeric.after(3).T, numeric.after(2).T).norm() > 1e-4;
  }
  EXPECT_GT(unsettled, 50) << "a third step would have been small anyway";
}

TEST(EkfPoseUpdate, TheGateDecidesOnUncheckedStates) {
  Rng rng(22);
  const PoseWithCovariance prior = paperPrior();
  EkfParams two;
  two.iterations = 2;
  int accepted = 0, refused = 0;
  for (int i = 0; i < 200; ++i) {
    const auto [scene, model] = randomPair(rng, prior);
    EkfParams open = two;
    open.gate = std::numeric_limits<double>::max();
    const EkfUpdate u = ekfPoseUpdate(scene, model, prior, open);
    if (!u.accepted) continue;  // turned out of min_cosine
    const bool within = u.cost <= two.gate;
    EXPECT_EQ(ekfPoseUpdate(scene, model, prior, two).accepted, within);
    (within ? accepted : refused) += 1;
  }
  EXPECT_GT(accepted, 100);
  EXPECT_GT(refused, 0);
}

TEST(EkfPoseUpdate, ManyLinearisationsSettleOrAreRefused) {
  Rng rng(23);
  const PoseWithCovariance prior = paperPrior();
  int settled = 0, refused = 0;
  for (int i = 0; i < 2000; ++i) {
    const Segment scene = test::randomSegment(rng), model = test::randomSegment(rng);  // any two planes
    if (!ekfPoseUpdate(scene, model, prior, ungated(2)).accepted) continue;
    const EkfUpdate u = ekfPoseUpdate(scene, model, prior, ungated());
    if (!u.accepted) {
      ++refused;
      continue;
    }
    ++settled;
    const EkfUpdate longer = ekfPoseUpdate(scene, model, prior, ungated(100));
    ASSERT_TRUE(longer.accepted);
    EXPECT_THAT(longer.pose.T, PoseNear(u.pose.T, 1e-12, 1e-10)) << "no step is left to take";
  }
  EXPECT_GT(settled, 100);
  EXPECT_GT(refused, 0);
}

// Everything about an update that does not depend on the error of the measurement.
class RandomUpdates : public testing::Test {
protected:
  void forEach(int n, const std::function<void(const Segment&, const Segment&, const PoseWithCovariance&,
                                               const EkfUpdate&)>& check) {
    Rng rng(7);
    for (int i = 0; i < n; ++i) {
      const PoseWithCovariance prior = narrowPrior(rng);
      const auto [scene, model] = randomPair(rng, prior);
      const EkfUpdate u = ekfPoseUpdate(scene, model, prior, ungated());
      ASSERT_TRUE(u.accepted);
      check(scene, model, prior, u);
    }
  }
  // Takes the posterior covariance back to the tangent space of the prior mean, where it was computed.
  static Matrix6d beforeReset(const PoseWithCovariance& prior, const EkfUpdate& u,
                              Matrix6d* reset = nullptr) {
    Matrix6d G = Matrix6d::Identity();
    G.topLeftCorner<3, 3>() = leftJacobianSO3(boxminus(u.pose.T, prior.T).head<3>());
    if (reset) *reset = G;
    const Matrix6d back = G.inverse();
    return back * u.pose.P * back.transpose();
  }
};

TEST_F(RandomUpdates, CovarianceStaysPositiveAndNeverGrows) {
  forEach(500, [](auto&, auto&, const PoseWithCovariance& prior, const EkfUpdate& u) {
    EXPECT_THAT(u.pose.P, IsPositiveSemidefinite(1e-15));
    EXPECT_THAT((prior.P - beforeReset(prior, u)).eval(), IsPositiveSemidefinite(1e-12));
  });
}

TEST_F(RandomUpdates, GainIsTheInformationThatThePairAdds) {
  forEach(500, [](auto&, auto&, const PoseWithCovariance& prior, const EkfUpdate& u) {
    Matrix6d reset;
    const Matrix6d P = beforeReset(prior, u, &reset), added = reset.transpose() * u.information * reset;
    const double by_information = 0.5 * std::log((Matrix6d::Identity() + prior.P * added).determinant());
    EXPECT_GE(u.gain, 0);
    EXPECT_NEAR(u.gain, by_information, 1e-5);
    EXPECT_NEAR(u.gain, 0.5 * std::log(prior.P.determinant() / P.determinant()), 1e-5);
    // Adding information is the whole update; inverted in more digits than the update itself has.
    using Precise = Eigen::Matrix<long double, 6, 6>;
    const Precise sum = prior.P.cast<long double>().inverse() + added.cast<long double>();
    EXPECT_THAT(P, MatrixNear(sum.inverse().cast<double>(), 1e-5 * P.norm()));  // as exact as the last step
  });
}

TEST_F(RandomUpdates, CostIsThatOfTheMaximumAPosteriori) {
  forEach(500, [](const Segment& scene, const Segment& model, const PoseWithCovariance& prior,
                  const EkfUpdate& u) {
    const auto cost = [&](const Vector6d& e) {
      PlaneMeasurement m;
      EXPECT_TRUE(measurePlane(scene, model, boxplus(prior.T, e), 0, m));
      return e.dot(prior.P.llt().solve(e)) + m.h.dot(m.W.llt().solve(m.h));
    };
    const Vector6d e = boxminus(u.pose.T, prior.T);
    EXPECT_NEAR(u.cost, cost(e), 1e-4 * (1 + u.cost));  // the last step, of at most 1e-5, is still in it
  });
}

TEST_F(RandomUpdates, ADuplicateOfAPairAddsInformation) {
  forEach(200, [](const Segment& scene, const Segment& model, const PoseWithCovariance&, const EkfUpdate& u) {
    const EkfUpdate again = ekfPoseUpdate(scene, model, u.pose, ungated());
    ASSERT_TRUE(again.accepted);
    EXPECT_GT(again.gain, 0);
    EXPECT_LT(again.gain, u.gain);
    EXPECT_LT(again.pose.P.determinant(), u.pose.P.determinant());
    EXPECT_THAT((u.pose.P - beforeReset(u.pose, again)).eval(), IsPositiveSemidefinite(1e-12));
  });
}

TEST_F(RandomUpdates, PosesMoveWithTheFrameOfTheModel) {
  Rng rng(8);
  forEach(200, [&rng](const Segment& scene, const Segment& model, const PoseWithCovariance& prior,
                      const EkfUpdate& u) {
    const Eigen::Isometry3d X = test::randomPose(rng, 3, 5);
    Matrix6d A = Matrix6d::Zero();
    A.topLeftCorner<3, 3>() = A.bottomRightCorner<3, 3>() = X.linear();
    const EkfUpdate moved =
        ekfPoseUpdate(scene, transformed(model, X), {X * prior.T, A * prior.P * A.transpose()}, ungated());
    ASSERT_TRUE(moved.accepted);
    EXPECT_THAT(moved.pose.T, PoseNear(X * u.pose.T, 1e-9, 1e-8));
    EXPECT_THAT(moved.pose.P, MatrixNear(A * u.pose.P * A.transpose(), 1e-9));
    EXPECT_NEAR(moved.cost, u.cost, 1e-8 * (1 + u.cost));
    EXPECT_NEAR(moved.gain, u.gain, 1e-8);
  });
}

TEST_F(RandomUpdates, PosesMoveWithTheFrameOfTheCamera) {
  Rng rng(9);
  forEach(200, [&rng](const Segment& scene, const Segment& model, const PoseWithCovariance& prior,
                      const EkfUpdate& u) {
    // Turned axes of the camera: exact. (A moved origin changes the meaning of "Gaussian in (phi, t)".)
    Eigen::Isometry3d Y(test::randomRotation(rng));
    const EkfUpdate moved =
        ekfPoseUpdate(transformed(scene, Y), model, {prior.T * Y.inverse(), prior.P}, ungated());
    ASSERT_TRUE(moved.accepted);
    EXPECT_THAT(moved.pose.T, PoseNear(u.pose.T * Y.inverse(), 1e-9, 1e-8));
    EXPECT_THAT(moved.pose.P, MatrixNear(u.pose.P, 1e-9));
    EXPECT_NEAR(moved.cost, u.cost, 1e-8 * (1 + u.cost));
  });
}

TEST(EkfPoseUpdate, AMovedOriginOfTheCameraChangesNothingToFirstOrder) {
  Rng rng(10);
  for (int i = 0; i < 100; ++i) {
    PoseWithCovariance prior = narrowPrior(rng);
    prior.P *= 1e-4;
    Segment surface = test::randomSegment(rng);
    surface.Sigma_q *= 1e-4;
    const Eigen::Isometry3d truth = boxplus(prior.T, gaussian<6>(rng, prior.P));
    const Segment scene = seen(surface, truth, surface.Sigma_q, rng), model = measured(surface, rng);
    const Eigen::Isometry3d Y = test::randomPose(rng, 2, 1);
    Matrix6d A = Matrix6d::Identity();  // t' = t - R Y^-1 t_Y moves with the rotation
    A.bottomLeftCorner<3, 3>() = skew(prior.T.linear() * Y.linear().transpose() * Y.translation());
    const EkfUpdate u = ekfPoseUpdate(scene, model, prior, ungated());
    const EkfUpdate moved = ekfPoseUpdate(transformed(scene, Y), model,
                                          {prior.T * Y.inverse(), A * prior.P * A.transpose()}, ungated());
    ASSERT_TRUE(u.accepted && moved.accepted);
    EXPECT_THAT(moved.pose.T, PoseNear(u.pose.T * Y.inverse(), 1e-5, 1e-4));
    EXPECT_NEAR(moved.cost, u.cost, 1e-2 * (1 + u.cost));
  }
}

// How far, in standard deviations, the posteriors of all orders of three pairs lie apart; sorted over trials.
std::vector<double> spreadOverOrders(double prior_scale) {
  Rng rng(11);
  PoseWithCovariance prior = paperPrior();
  prior.P *= prior_scale * prior_scale;
  std::vector<double> spread;
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Isometry3d truth = boxplus(prior.T, gaussian<6>(rng, prior.P));
    std::array<Segment, 3> scene, model = corner(rng);
    for (int k = 0; k < 3; ++k) {
      scene[k] = seen(model[k], truth, model[k].Sigma_q, rng);
      model[k] = measured(model[k], rng);
    }
    std::array<int, 3> order{0, 1, 2};
    std::vector<PoseWithCovariance> poses;
    do {
      PoseWithCovariance pose = prior;
      bool all = true;
      for (const int k : order) {
        const EkfUpdate u = ekfPoseUpdate(scene[k], model[k], pose, ungated(50));
        all = all && u.accepted;
        pose = u.pose;
      }
      if (all) poses.push_back(pose);
    } while (std::next_permutation(order.begin(), order.end()));
    double worst = 0;
    for (const PoseWithCovariance& p : poses) {
      const Vector6d e = boxminus(p.T, poses[0].T);
      worst = std::max(worst, (e.cwiseAbs().array() / poses[0].P.diagonal().cwiseSqrt().array()).maxCoeff());
    }
    spread.push_back(worst);
  }
  std::sort(spread.begin(), spread.end());
  return spread;
}

TEST(EkfPoseUpdate, OrderOfThreePairsHardlyMatters) {
  // The spread is a tenth of a standard deviation from a start that is known to about a degree.
  EXPECT_LT(spreadOverOrders(0.05)[190], 0.1);
  // Gaussians in sequence are not one posterior any more from 20 deg and 1 m; joint refinement exists for
  // that.
  EXPECT_LT(spreadOverOrders(1)[100], 0.5);  // median observed: 0.25
}

TEST(EkfPoseUpdate, ThreeExactPairsGiveThePose) {
  Rng rng(12);
  const PoseWithCovariance prior = paperPrior();
  int found = 0;
  for (int i = 0; i < 100; ++i) {
    std::array<Segment, 3> model = corner(rng);
    const Eigen::Isometry3d truth = boxplus(prior.T, gaussian<6>(rng, prior.P));
    PoseWithCovariance pose = prior;
    bool all = true;
    for (Segment& s : model) {
      s.Sigma_q *= 1e-6;
      const EkfUpdate u = ekfPoseUpdate(transformed(s, truth.inverse()), s, pose, ungated());
      all = all && u.accepted;
      if (all) pose = u.pose;
    }
    if (!all) continue;
    ++found;
    EXPECT_THAT(pose.T, PoseNear(truth, 0.01, 0.1));
  }
  EXPECT_GE(found, 95);
}

TEST(EkfPoseUpdate, MismatchedPairsAreRefused) {
  Rng rng(13);
  const PoseWithCovariance prior = narrowPrior(rng);
  const Segment surface = test::randomSegment(rng), scene = transformed(surface, prior.T.inverse());
  EXPECT_TRUE(ekfPoseUpdate(scene, surface, prior).accepted);
  Segment other = surface;
  other.t += 2 * surface.normal();
  EXPECT_FALSE(ekfPoseUpdate(scene, other, prior).accepted);  // far off along the normal
  other = surface;
  other.R = expSO3(1.2 * surface.R.col(0)) * surface.R;
  EXPECT_FALSE(ekfPoseUpdate(scene, other, prior).accepted);  // turned out of min_cosine
  other.R.col(1) = -surface.R.col(1);
  other.R.col(2) = -surface.R.col(2);
  EXPECT_FALSE(ekfPoseUpdate(scene, other, prior).accepted);  // seen from the other side
}

TEST(EkfPoseUpdate, NaNsAreRefused) {
  Rng rng(14);
  const PoseWithCovariance prior = narrowPrior(rng);
  const Segment surface = test::randomSegment(rng);
  Segment scene = transformed(surface, prior.T.inverse());
  scene.t.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(ekfPoseUpdate(scene, surface, prior).accepted);
  PoseWithCovariance unknown = prior;
  unknown.P.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE(ekfPoseUpdate(transformed(surface, prior.T.inverse()), surface, unknown).accepted);
}

}  // namespace
}  // namespace facetloc
