// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/evaluate_app.h"

int main(int argc, char** argv) {
  facetloc::EvaluateApp app;
  return facetloc::runApp(app, argc, argv);
}
