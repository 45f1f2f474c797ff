// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/registration/consensus.h>
#include <facetloc/registration/depth_alignment.h>
#include <facetloc/registration/hypothesis_tree.h>
#include <facetloc/registration/joint_refinement.h>

namespace facetloc {

/** \brief Parameters of the registration of one view with another; every step can be switched off. */
struct ViewRegistrationParams {
  MatchingParams matching;
  EkfParams ekf;
  HypothesisTreeParams tree;
  bool joint_refinement = true;
  bool floor_information = true;  ///< where pairs alone fix no pose, what is known without them counts too
  bool depth_assistance = true;   ///< the dense last-degree-of-freedom step
  int max_assisted = 1;           ///< incomplete poses per local model that depth may complete
  DepthAlignmentParams alignment;
  DepthConsistencyParams depth;
  ConsensusParams consensus;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& field) {
    MatchingParams::describe(p.matching, field);
    EkfParams::describe(p.ekf, field);
    HypothesisTreeParams::describe(p.tree, field);
    field("joint_refinement", p.joint_refinement, false, true,
          "Re-estimate each hypothesis from all pairs that agree with it.");
    field(
        "floor_information", p.floor_information, false, true,
        "Where planes alone fix no pose, count what the camera's mounting tells of roll, pitch and height.");
    field("depth_assistance", p.depth_assistance, false, true,
          "Find a translation that the planes leave free by dense depth.");
    field("max_assisted", p.max_assisted, 0, 1000,
          "Incomplete poses per local model that depth may complete.");
    DepthAlignmentParams::describe(p.alignment, field);
    DepthConsistencyParams::describe(p.depth, field);
    ConsensusParams::describe(p.consensus, field);
  }
  void validate() const { checkRanges(*this); }
};

/** \brief Registers a scene with one local model: match, search, refine, complete by depth, score.
 *
 * \return hypotheses by decreasing score (score = consensus + free-space term; no world pose, no
 * probability). */
class ViewRegistration {
public:
  /** \param known information about T_m_c that no view needs to tell, such as floorInformation() */
  explicit ViewRegistration(const ViewRegistrationParams& params = {}, const SensorNoise& noise = {},
                            const Matrix6d& known = Matrix6d::Zero());
  const ViewRegistrationParams& params() const { return params_; }
  const DepthComparison& comparison() const { return comparison_; }
  const Matrix6d& known() const { return known_; }  ///< zero if that does not count

  /** \brief False if the planes of a view tell so little that align() has no answer, whatever the model. */
  bool mayFixPose(const View& scene) const;

  /** \param prior T_m_c before anything was seen
   * \param start about where correspondences are looked for: the prior, or what else tells the pose */
  std::vector<Hypothesis> align(const View& scene,
                                const std::vector<std::vector<Eigen::Vector3d>>& scene_samples,
                                const View& model, const PoseWithCovariance& prior,
                                const PoseWithCovariance& start) const;
  std::vector<Hypothesis> align(const View& scene, const View& model, const PoseWithCovariance& prior) const {
    return align(scene, samplePoints(scene), model, prior, prior);
  }
  /** \brief The hypothesis next to a start, from all pairs that agree there, without a search; none if no
   * pair does. Its score is that of align(), from fewer pixels. A tenth of the work of align(). */
  std::optional<Hypothesis> alignFrom(const PoseWithCovariance& start, const View& scene,
                                      const std::vector<std::vector<Eigen::Vector3d>>& scene_samples,
                                      const View& model) const;

private:
  void score(const View& scene, const std::vector<std::vector<Eigen::Vector3d>>& scene_samples,
             const View& model, int columns, Hypothesis& h) const;
  void addComplete(const View& scene, const View& model, const PoseWithCovariance& prior,
                   const std::vector<PoseNode>& complete, std::vector<Hypothesis>& hypotheses) const;
  void addDistinct(Hypothesis&& h, std::vector<Hypothesis>& hypotheses) const;
  void completeByDepth(const View& scene, const View& model, const PoseWithCovariance& prior,
                       const std::vector<PoseNode>& incomplete, std::vector<Hypothesis>& hypotheses) const;

  ViewRegistrationParams params_;
  DepthComparison comparison_;
  Matrix6d known_ = Matrix6d::Zero();
};

/** \brief Which motions of the camera the segments of a view leave free, in words and camera axes, such as
 * "translation along (1.00, 0.02, 0.00)"; empty if they, with what is known without them, fix all six degrees
 * of freedom. */
std::string unconstrainedDirections(const std::vector<Segment>& segments, double max_rotation_std_deg,
                                    double max_translation_std, const Matrix6d& known = Matrix6d::Zero());

}  // namespace facetloc
