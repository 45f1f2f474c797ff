// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/apps/evaluate_app.h>

int main(int argc, char** argv) {
  facetloc::EvaluateApp app;
  return facetloc::runApp(app, argc, argv);
}
