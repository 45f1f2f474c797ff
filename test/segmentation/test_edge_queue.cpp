// SPDX-License-Identifier: BSD-3-Clause
#include "edge_queue.h"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <tuple>

namespace facetloc {
namespace {

using namespace internal;
using Edge = EdgeQueue::Edge;

struct Order {
  bool operator()(const Edge& x, const Edge& y) const {
    return std::tie(x.cost, x.a, x.b) < std::tie(y.cost, y.a, y.b);
  }
};

bool always(const Edge&) { return true; }

// Against a sorted set, with pushes below and above the last cost taken, ties, and edges that go out of date.
TEST(EdgeQueue, GivesTheCheapestCurrentEdgeAsASortedSetDoes) {
  constexpr float kMaxCost = 2.75f;
  std::mt19937 random(1);
  const auto below = [&random](int n) { return static_cast<int>(random() % n); };
  EdgeQueue queue;
  for (int repetition = 0; repetition < 20; ++repetition) {  // with the same object
    queue.clear(kMaxCost);
    std::set<Edge, Order> expected;
    std::vector<std::uint32_t> version(50, 0);
    const auto is_current = [&version](const Edge& e) {
      return version[e.a] == e.version_a && version[e.b] == e.version_b;
    };
    for (int step = 0; step < 2000; ++step) {
      if (below(3) > 0) {
        const int a = below(50), b = below(50);
        const Edge e{kMaxCost * static_cast<float>(below(400)) / 399.f, a, b, version[a], version[b]};
        if (expected.insert(e).second) queue.push(e);
      } else if (below(4) == 0) {
        const int changed = below(50);
        ++version[changed];
        for (auto e = expected.begin(); e != expected.end();)
          e = e->a == changed || e->b == changed ? expected.erase(e) : std::next(e);
      } else {
        Edge cheapest;
        const bool found = queue.pop(cheapest, is_current);
        ASSERT_EQ(found, !expected.empty());
        if (!found) continue;
        EXPECT_FALSE(Order()(cheapest, *expected.begin()) || Order()(*expected.begin(), cheapest));
        expected.erase(expected.begin());
      }
    }
    Edge cheapest;
    for (const Edge& e : expected) {
      ASSERT_TRUE(queue.pop(cheapest, is_current));
      EXPECT_FALSE(Order()(cheapest, e) || Order()(e, cheapest));
    }
    EXPECT_FALSE(queue.pop(cheapest, is_current));
  }
}

TEST(EdgeQueue, TakesTheLargestCostAndCostsOfZero) {
  EdgeQueue queue;
  queue.clear(2.75);
  queue.push({2.75f, 1, 2, 0, 0});
  queue.push({0.f, 3, 4, 0, 0});
  Edge e;
  ASSERT_TRUE(queue.pop(e, always));
  EXPECT_EQ(e.a, 3);
  ASSERT_TRUE(queue.pop(e, always));
  EXPECT_EQ(e.a, 1);
  EXPECT_FALSE(queue.pop(e, always));
}

}  // namespace
}  // namespace facetloc
