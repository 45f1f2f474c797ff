// SPDX-License-Identifier: BSD-3-Clause
#include "base/localization_report.h"
#include "base/results_journal.h"
#include "tool_runner.h"

#include <gmock/gmock.h>

namespace facetloc {
namespace {

FrameResult exampleResult(const std::string& frame, int rows) {
  FrameResult result;
  result.stamp = 1.0 / 3;
  result.timing = {frame, 1.5, 0.25, 70.125, 142};
  for (int i = 1; i <= rows; ++i) {
    ResultRow row;
    row.frame = frame;
    row.rank = i;
    row.model = "model \"" + std::to_string(i) + "\"";
    row.probability = 1.0 / i;
    row.score = -1e-300 * i;
    row.T_m_c = Eigen::AngleAxisd(0.1 * i, Eigen::Vector3d(1, 2, 3).normalized()) *
                Eigen::Translation3d(1, 2, 1.0 / 7);
    if (i % 2) row.T_w_c = row.T_m_c.inverse();
    row.sd_rot_deg = 0.1;
    row.reason = i == 1 ? "" : "depth-assisted, twice";
    row.state = AnswerState::doubtful;
    row.part = i % 2 ? "" : "a part";
    if (i == 1) row.P_w_c = Matrix6d::Identity() / 3 + 0.1 * Matrix6d::Ones();
    result.rows.push_back(row);
  }
  if (rows == 0) result.rows = {noHypothesis(frame, "the view shows no planar segment")};
  return result;
}

void expectSame(const FrameResult& a, const FrameResult& b) {
  EXPECT_EQ(a.stamp, b.stamp);
  EXPECT_EQ(a.timing.frame, b.timing.frame);
  EXPECT_EQ(a.timing.localize_ms, b.timing.localize_ms);
  EXPECT_EQ(a.timing.models, b.timing.models);
  ASSERT_EQ(a.rows.size(), b.rows.size());
  for (std::size_t i = 0; i < a.rows.size(); ++i) {
    const ResultRow &x = a.rows[i], &y = b.rows[i];
    EXPECT_EQ(x.frame, y.frame);
    EXPECT_EQ(x.rank, y.rank);
    EXPECT_EQ(x.model, y.model);
    EXPECT_EQ(x.probability, y.probability);
    EXPECT_EQ(x.score, y.score);
    EXPECT_EQ(x.T_m_c.matrix(), y.T_m_c.matrix());
    EXPECT_EQ(x.T_w_c.has_value(), y.T_w_c.has_value());
    if (x.T_w_c && y.T_w_c) {
      EXPECT_EQ(x.T_w_c->matrix(), y.T_w_c->matrix());
    }
    EXPECT_EQ(x.P_w_c, y.P_w_c);
    EXPECT_EQ(x.reason, y.reason);
    EXPECT_EQ(x.state, y.state);
    EXPECT_EQ(x.part, y.part);
  }
}

class ResultsJournalTest : public testing::Test {
protected:
  test::TemporaryFolder folder_;
  const std::string file_ = folder_ / "partial.txt";
};

TEST_F(ResultsJournalTest, KeepsResultsToTheLastBit) {
  ResultsJournal journal(folder_ / ".");
  EXPECT_FALSE(journal.exists());
  journal.begin({});
  journal.append("a b", exampleResult("a b", 3));
  journal.append("c", exampleResult("c", 0));
  const auto results = ResultsJournal(folder_ / ".").read();
  ASSERT_EQ(results.size(), 2u);
  expectSame(results.at("a b"), exampleResult("a b", 3));
  expectSame(results.at("c"), exampleResult("c", 0));
  journal.remove();
  EXPECT_FALSE(journal.exists());
}

TEST_F(ResultsJournalTest, IgnoresWhatAKilledRunLeftHalfWritten) {
  ResultsJournal journal(folder_ / ".");
  journal.begin({});
  journal.append("first", exampleResult("first", 2));
  const std::size_t whole = test::contentOf(file_).size();
  journal.append("second", exampleResult("second", 2));
  const std::string content = test::contentOf(file_);
  for (std::size_t n = whole; n + 1 < content.size(); n += 7) {
    test::writeContent(file_, content.substr(0, n));
    const auto results = journal.read();
    EXPECT_EQ(results.size(), 1u) << n;
    EXPECT_EQ(results.count("first"), 1u) << n;
  }
}

/** Whatever byte is damaged: its frame is done again, and no wrong number is believed. */
TEST_F(ResultsJournalTest, IgnoresALineThatWasDamaged) {
  ResultsJournal journal(folder_ / ".");
  journal.begin({});
  journal.append("first", exampleResult("first", 1));
  journal.append("second", exampleResult("second", 1));
  const std::string content = test::contentOf(file_);
  const std::size_t first_line = content.find('\n');
  for (std::size_t i = 0; i < first_line; ++i) {
    std::string damaged = content;
    damaged[i] = static_cast<char>(damaged[i] ^ 1);
    test::writeContent(file_, damaged);
    const auto results = journal.read();
    EXPECT_EQ(results.size(), 1u) << i;
    EXPECT_EQ(results.count("second"), 1u) << i;
  }
}

TEST_F(ResultsJournalTest, BeginsWithEarlierResults) {
  ResultsJournal journal(folder_ / ".");
  journal.begin({{"old", exampleResult("old", 1)}});
  journal.append("new", exampleResult("new", 1));
  EXPECT_EQ(journal.read().size(), 2u);
}

TEST_F(ResultsJournalTest, RanksHaveFilesOfTheirOwnAndShareWhatIsInThem) {
  ResultsJournal first(folder_ / "."), second(folder_ / ".", 1), twelfth(folder_ / ".", 11);
  first.begin({});
  second.begin({});
  twelfth.begin({});
  EXPECT_TRUE(std::filesystem::exists(folder_ / "partial.11.txt"));
  first.append("a", exampleResult("a", 1));
  second.append("b", exampleResult("b", 1));
  twelfth.append("c", exampleResult("c", 1));
  test::writeContent(folder_ / "partial.old.txt", "of somebody else");
  EXPECT_EQ(first.read().size(), 3u);

  ResultsJournal next(folder_ / ".");  // of the first rank, perhaps of fewer
  next.begin(first.read());
  EXPECT_FALSE(std::filesystem::exists(folder_ / "partial.1.txt"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "partial.11.txt"));
  EXPECT_EQ(next.read().size(), 3u);
  ResultsJournal(folder_ / ".", 1).begin({});
  EXPECT_EQ(next.read().size(), 3u);
  next.remove();
  EXPECT_FALSE(next.exists());
  EXPECT_TRUE(std::filesystem::exists(folder_ / "partial.old.txt"));
}

}  // namespace
}  // namespace facetloc
