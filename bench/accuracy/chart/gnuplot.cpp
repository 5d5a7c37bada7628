#include "gnuplot.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <stdexcept>

namespace farfield::bench {
namespace {

constexpr int not_there = 127;  // what shells say, too

/// The program's exit status; not_there without such a program. What it prints is not for users.
int run_gnuplot(const std::filesystem::path& directory, const std::string& script) {
    const pid_t child = fork();
    if (child == 0) {
        const int nothing = open("/dev/null", O_RDWR);
        for (const int stream : {0, 1, 2}) dup2(nothing, stream);
        if (chdir(directory.c_str()) != 0) _exit(1);
        execlp("gnuplot", "gnuplot", script.c_str(), static_cast<char*>(nullptr));
        _exit(errno == ENOENT ? not_there : 1);
    }
    int status = 0;
    if (child < 0) return 1;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

}  // namespace

std::string draw_charts(const std::vector<Chart>& charts, const std::filesystem::path& directory) {
    std::vector<std::string> labels;
    for (const Chart& chart : charts) {
        for (const Panel& panel : chart.panels) {
            for (const Series& s : panel.series) {
                if (std::find(labels.begin(), labels.end(), s.label) == labels.end()) labels.push_back(s.label);
            }
        }
    }
    std::filesystem::create_directories(directory / "charts");
    for (const Chart& chart : charts) {
        std::ofstream out(directory / script_file(chart));
        out << gnuplot_script(chart, labels) << std::flush;
        if (!out) throw std::runtime_error("could not write " + (directory / script_file(chart)).string());
    }
    std::string failed;
    for (const Chart& chart : charts) {
        const auto svg = directory / svg_file(chart), script = directory / script_file(chart);
        std::filesystem::remove(svg);  // not one of an earlier run
        const int status = run_gnuplot(script.parent_path(), script.filename().string());
        if (status == not_there) {
            return "no charts: gnuplot was not found (Debian and Ubuntu: gnuplot-nox); with it, --from draws them";
        }
        if (status != 0 || !std::filesystem::exists(svg)) failed = script.string();
    }
    return failed.empty() ? "" : "gnuplot could not draw " + failed;
}

}  // namespace farfield::bench
