// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <cstdlib>

#include "experiment.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/tactile/biotac/normal.hpp"
#include "tactile/biotac_logs.hpp"

namespace {

using namespace palpate;
using namespace palpate::tactile;
using experiment::Options;

constexpr int kFolds = 10;
constexpr double kRidge = 0.01;  // of the features' variance, the best of 1e-4 .. 0.1

/// Ridge regression on a frame's log pressure, shares and changes, of the samples and their mirror
/// images: what a model has to beat.
class Ridge {
 public:
  explicit Ridge(const std::vector<BiotacSample>& samples) {
    Eigen::MatrixXd X(kFeatures, std::ssize(samples));
    Eigen::MatrixXd normals(3, std::ssize(samples));
    for (Eigen::Index i = 0; i < X.cols(); ++i) {
      const BiotacSample& sample = samples[static_cast<std::size_t>(i)];
      X.col(i) = features(sample.change);
      normals.col(i) = sample.n;
    }
    const auto count = static_cast<double>(X.cols());
    mean_ = X.rowwise().mean();
    X.colwise() -= mean_;
    scale_ = (X.rowwise().squaredNorm() / count).cwiseSqrt().cwiseMax(1e-6);
    X = scale_.cwiseInverse().asDiagonal() * X;
    mean_normal_ = normals.rowwise().mean();
    normals.colwise() -= mean_normal_;
    Eigen::MatrixXd squares = X * X.transpose();
    squares.diagonal().array() += kRidge * count;
    weights_ = squares.llt().solve(X * normals.transpose());
  }

  Eigen::Vector3d operator()(const BiotacChannels& change) const {
    const Eigen::VectorXd x = (features(change) - mean_).cwiseQuotient(scale_);
    return (mean_normal_ + weights_.transpose() * x).normalized();
  }

 private:
  static constexpr Eigen::Index kFeatures = 1 + kElectrodes + kBiotacChannels;

  static Eigen::VectorXd features(const BiotacChannels& change) {
    const auto electrodes = change.tail<kElectrodes>();
    Eigen::VectorXd result(kFeatures);
    result << std::log(std::max(change[0], 5.0)),
        kElectrodes * electrodes / (electrodes.cwiseAbs().sum() + 20), change / 100;
    return result;
  }

  Eigen::VectorXd mean_, scale_;
  Eigen::Vector3d mean_normal_;
  Eigen::MatrixXd weights_;
};

/// Logs to learn from and logs to test with, which differ in the normals that they keep.
struct Split {
  std::vector<BiotacLog> learn, test;
};

/// Ten splits; each keeps the normals of a run of whole touches for the test.
std::vector<Split> touches_left_out(const BiotacLog& log) {
  std::vector<int> touch(log.time.size(), -1);
  const BiotacSignals signals = biotac_signals(log);
  int touches = 0;
  for (std::size_t i = 0; i < touch.size(); ++i) {
    if (!biotac_usable(signals.flags[i])) continue;
    if (i == 0 || touch[i - 1] < 0) ++touches;
    touch[i] = touches - 1;
  }
  std::vector<Split> splits;
  for (int fold = 0; fold < kFolds; ++fold) {
    Split split{{log}, {log}};
    for (std::size_t i = 0; i < touch.size(); ++i) {
      const bool left_out = touch[i] >= 0 && touch[i] * kFolds / touches == fold;
      (left_out ? split.learn : split.test).front().normals[i].reset();
    }
    splits.push_back(std::move(split));
  }
  return splits;
}

std::vector<Split> short_logs_left_out(const std::vector<BiotacLog>& logs) {
  std::vector<Split> splits;
  for (std::size_t i = 1; i < logs.size(); ++i) {
    Split split{.learn = logs, .test = {logs[i]}};
    split.learn.erase(split.learn.begin() + static_cast<std::ptrdiff_t>(i));
    splits.push_back(std::move(split));
  }
  return splits;
}

struct Errors {
  std::vector<double> ridge, ridge_causal;  // deg
  BiotacNormalErrors whole, causal;
};

std::vector<double> ridge_errors(const Ridge& ridge, const BiotacLog& log, BiotacRest rest) {
  const BiotacSignals signals = biotac_signals(log, rest);
  std::vector<double> errors;
  for (std::size_t i = 0; i < log.time.size(); ++i) {
    if (!log.normals[i] || !biotac_usable(signals.flags[i])) continue;
    errors.push_back(angle_between_deg(ridge(signals.changes[i]), *log.normals[i]));
  }
  return errors;
}

Errors evaluate(const std::vector<Split>& splits) {
  Errors errors;
  const auto append = [](const std::vector<double>& more, std::vector<double>& all) {
    all.insert(all.end(), more.begin(), more.end());
  };
  for (const Split& split : splits) {
    std::vector<BiotacSample> samples;
    for (const BiotacLog& log : split.learn) {
      const auto more = biotac_samples(log);
      samples.insert(samples.end(), more.begin(), more.end());
      for (const BiotacSample& sample : more) samples.push_back(mirrored(sample));
    }
    const Ridge ridge(samples);
    const auto model = train_biotac_normal(split.learn);
    for (const BiotacLog& log : split.test) {
      append(ridge_errors(ridge, log, BiotacRest::whole_log), errors.ridge);
      append(ridge_errors(ridge, log, BiotacRest::causal), errors.ridge_causal);
      errors.whole.add(evaluate_biotac_normal(model, log, BiotacRest::whole_log));
      errors.causal.add(evaluate_biotac_normal(model, log, BiotacRest::causal));
    }
  }
  return errors;
}

void add_rows(experiment::Table& table, const std::string& what, const Errors& errors) {
  const auto row = [&](const std::string& model, const std::vector<double>& of) {
    return std::vector<std::string>{what, model, fmt::format("{}", of.size()),
                                    fmt::format("{:.2f}", median(of)),
                                    fmt::format("{:.2f}", quantile(of, 0.9))};
  };
  const auto add = [&](const std::string& model, const std::vector<double>& of,
                       const BiotacNormalErrors* stated) {
    auto cells = row(model, of);
    cells.push_back(stated ? fmt::format("{:.2f}", mean(stated->normalised)) : "-");
    cells.push_back(stated ? fmt::format("{:.3f}", stated->coverage_95()) : "-");
    table.add_row(cells);
  };
  add("ridge, whole log", errors.ridge, nullptr);
  add("model, whole log", errors.whole.error_deg, &errors.whole);
  add("ridge, causal", errors.ridge_causal, nullptr);
  add("model, causal", errors.causal.error_deg, &errors.causal);
}

std::vector<BiotacLog> real_logs(const std::filesystem::path& folder) {
  std::vector<BiotacLog> logs;
  for (const char* name : {"15330", "15258", "15506", "15543"}) {
    logs.push_back(
        read_biotac_log(folder / fmt::format("biotac_robotic_finger/trial_{}.csv", name)));
  }
  return logs;
}

void run(const Options& options) {
  const char* const folder = std::getenv("PALPATE_DATA");
  const bool real = folder && !options.quick;
  std::vector<BiotacLog> logs;
  if (real) {
    logs = real_logs(folder);
  } else {
    fmt::print("made-up logs: PALPATE_DATA names no folder with real ones, or --quick\n");
    logs = {made_up_log(1, 10), made_up_log(2, 2), made_up_log(3, 2)};
  }
  experiment::Table table({"left out", "normals of", "frames", "median deg", "p90 deg",
                           "normalised error squared", "coverage of 95 %"});
  add_rows(table, "touches of the first log", evaluate(touches_left_out(logs.front())));
  add_rows(table, "each of the other logs", evaluate(short_logs_left_out(logs)));
  table.publish(options, "sessions", "Contact normals of touches and recordings left out");
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "biotac_sessions",
                         "Normals from a BioTac at touches and recordings that were not learned "
                         "from, against a ridge regression.",
                         run);
}
