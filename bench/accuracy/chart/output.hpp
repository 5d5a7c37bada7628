// Rows go to the file as soon as they are measured: what kills the program costs the row it was at.
#pragma once

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <utility>
#include <vector>

#include "csv.hpp"

namespace farfield::bench {

class Output {
  public:
    /// Overwrites the file. Throws std::runtime_error naming it, like add.
    explicit Output(std::filesystem::path file) : file_(std::move(file)), stream_(file_, std::ios::binary) {
        write(csv_header());
    }
    void add(Row row) {
        write(csv_line(row));
        rows_.push_back(std::move(row));
    }
    const std::vector<Row>& rows() const { return rows_; }

  private:
    void write(const std::string& line) {
        stream_ << line << std::flush;
        if (!stream_) throw std::runtime_error("could not write " + file_.string());
    }

    std::filesystem::path file_;
    std::ofstream stream_;
    std::vector<Row> rows_;
};

}  // namespace farfield::bench
