// SPDX-License-Identifier: MIT
// Compares actual errors of calibrations of simulated sets with their stated uncertainties.
//   uncertainty_bench [sets per row, default 500] [seed, default 1] [radtan | kannala_brandt
//                     [clean | outliers | bent | motion]]
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "alidade/core/parallel.h"
#include "support/coverage.h"

namespace alidade {
namespace {

std::vector<Judged> judgeSets(const std::string& model, Trouble trouble, int num_sets, std::uint64_t seed) {
  std::vector<Judged> judged(static_cast<std::size_t>(num_sets));
  parallelFor(judged.size(), 0, [&](std::size_t i) {
    judged[i] = judgeSet(drawTroubledSet(model, trouble, streamSeed(seed, i)), trouble);
  });
  return judged;
}

void printRow(const std::string& what, const Coverage& ordinary, const Coverage& by_views,
              const Coverage& stated) {
  std::printf("  %-10s", what.c_str());
  for (const Coverage& c : {ordinary, by_views, stated})
    std::printf("   %+7.3f %7.3f %7.1f", c.mean, c.std, 100 * c.covered);
  std::printf("\n");
}

void table(const std::string& model, Trouble trouble, int num_sets, std::uint64_t seed) {
  const std::vector<Judged> sets = judgeSets(model, trouble, num_sets, seed);
  int num_converged = 0;
  int num_exceeded = 0;
  double excess = 0;
  for (const Judged& set : sets) {
    num_converged += set.is_converged ? 1 : 0;
    num_exceeded += set.is_noise_exceeded ? 1 : 0;
    excess += set.excess / num_sets;
  }
  std::printf("%s, %s: %d of %d sets converged; noise exceeded in %.1f %%; mean excess %.2f\n", model.c_str(),
              std::string(troubleName(trouble)).c_str(), num_converged, num_sets,
              100.0 * num_exceeded / num_sets, excess);
  std::printf("  %-10s   %-25s %-25s %-25s\n", "", "ordinary: mean, std, 95%", "  by views", "   stated");
  using P = Judged::Parameter;
  const auto names = parameterNames(model);
  for (std::size_t k = 0; k < names.size(); ++k) {
    const int i = static_cast<int>(k);
    printRow(std::string(names[k]), coverageOf(sets, &P::std, i), coverageOf(sets, &P::std_by_views, i),
             coverageOf(sets, &P::stated_std, i));
  }
  printRow("all", coverageOf(sets, &P::std), coverageOf(sets, &P::std_by_views),
           coverageOf(sets, &P::stated_std));
  constexpr std::array kNames = {"centre", "mid", "corner"};
  for (const Place place : kAllPlaces) {
    const Coverage c = coverageOf(sets, place);
    std::printf("  projection, %-7s mean %+.3f std %.3f covered %.1f %%, by the ellipse %.1f %%\n",
                kNames[static_cast<std::size_t>(place)], c.mean, c.std, 100 * c.covered,
                100 * ellipseShare(sets, place));
  }
  std::fflush(stdout);
}

}  // namespace
}  // namespace alidade

int main(int argc, char** argv) {
  const int num_sets = argc > 1 ? std::atoi(argv[1]) : 500;
  const auto seed = static_cast<std::uint64_t>(argc > 2 ? std::atoll(argv[2]) : 1);
  const std::vector<std::string> models =
      argc > 3 ? std::vector<std::string>{argv[3]} : std::vector<std::string>{"radtan", "kannala_brandt"};
  const std::string only = argc > 4 ? argv[4] : "";
  if (num_sets < 1) {
    std::fprintf(stderr,
                 "usage: uncertainty_bench [sets a row, at least 1] [seed] [radtan | kannala_brandt "
                 "[clean | outliers | bent | motion]]\n");
    return 2;
  }
  for (const std::string& model : models) {
    for (const alidade::Trouble trouble : alidade::kAllTroubles) {
      if (alidade::troubleName(trouble).starts_with(only)) alidade::table(model, trouble, num_sets, seed);
    }
  }
  return 0;
}
