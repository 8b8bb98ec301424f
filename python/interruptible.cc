// SPDX-License-Identifier: MIT
#include "interruptible.h"

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

namespace alidade::python {
namespace {

namespace py = pybind11;

struct Report {
  const char* stage;
  std::size_t done;
  std::size_t total;
};

// State shared by the working and the calling thread.
class Progress {
 public:
  // Only the newest report of a stage matters.
  void add(const Report& report) {
    const std::lock_guard lock(mutex_);
    if (!reports_.empty() && reports_.back().stage == report.stage) {
      reports_.back() = report;
    } else {
      reports_.push_back(report);
    }
  }
  void finish() {
    const std::lock_guard lock(mutex_);
    is_finished_ = true;
    finished_.notify_all();
  }
  // Waits a little for the end of the work; true once it has ended.
  bool waitForEnd(std::vector<Report>& reports) {
    constexpr std::chrono::milliseconds kPoll(20);  // Ctrl-C feels immediate, and polling is cheap
    std::unique_lock lock(mutex_);
    finished_.wait_for(lock, kPoll, [this] { return is_finished_; });
    reports = std::exchange(reports_, {});
    return is_finished_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable finished_;
  std::vector<Report> reports_;
  bool is_finished_ = false;
};

}  // namespace

void runInterruptibly(const py::object& progress,
                      const std::function<void(const CancelFlag*, const ReportProgress&)>& work) {
  CancelFlag cancel{false};
  Progress shared;
  std::exception_ptr failure;
  std::optional<py::error_already_set> raised;  // from a signal handler or the callback
  {
    std::jthread worker([&] {
      try {
        work(&cancel, [&](const char* stage, std::size_t done, std::size_t total) {
          shared.add({.stage = stage, .done = done, .total = total});
        });
      } catch (...) {
        failure = std::current_exception();
      }
      shared.finish();
    });
    for (bool is_finished = false; !is_finished;) {
      std::vector<Report> reports;
      {
        const py::gil_scoped_release without_lock;
        is_finished = shared.waitForEnd(reports);
      }
      try {
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
        for (const Report& report : reports) {
          if (!progress.is_none() && !raised) progress(report.stage, report.done, report.total);
        }
      } catch (py::error_already_set& error) {
        if (!raised) raised.emplace(std::move(error));
        cancel = true;
      }
    }
  }
  if (raised) throw std::move(*raised);
  if (failure) std::rethrow_exception(failure);
}

}  // namespace alidade::python
