#include "../../bench/accuracy/chart/csv.hpp"

#include <algorithm>
#include <limits>
#include <sstream>

#include "catch.hpp"

using namespace farfield::bench;

namespace {

Row some_row() {
    Row row;
    row.chart = "accuracy";
    row.scene = "a tree, \"tall\"\nand old";
    row.triangles = 858'993'459;
    row.variant = "color-cube+shared";
    row.tolerance_px = 0.25;
    row.set_times_ms({1.5, 2, 1e-5});
    row.coverage_bias = -0.125;
    return row;
}

std::vector<Row> read(const std::string& text) {
    std::istringstream in(text);
    return read_csv(in);
}

}  // namespace

TEST_CASE("fields are quoted where they have to be") {
    CHECK(csv_field("plain") == "plain");
    CHECK(csv_field("") == "");
    CHECK(csv_field("a,b") == "\"a,b\"");
    CHECK(csv_field("say \"so\"") == "\"say \"\"so\"\"\"");
    CHECK(csv_field("two\nlines") == "\"two\nlines\"");
}

TEST_CASE("counts are told to the last digit, measurements to six") {
    CHECK(csv_number(0) == "0");
    CHECK(csv_number(858'993'459) == "858993459");
    CHECK(csv_number(9'007'199'254'740'991.0) == "9007199254740991");
    CHECK(csv_number(0.123456789) == "0.123457");
    CHECK(csv_number(-2.5) == "-2.5");
    CHECK(csv_number(1e300) == "1e+300");
    CHECK(csv_number(std::numeric_limits<double>::infinity()) == "inf");
}

TEST_CASE("what was written is read again") {
    Row other;
    other.chart = "growth";
    other.coverage_bias = std::numeric_limits<double>::infinity();
    const std::vector<Row> rows{some_row(), Row{}, other};
    std::string text = csv_header();
    for (const Row& row : rows) text += csv_line(row);
    CHECK(read(text) == rows);
    CHECK(read(csv_header()).empty());
}

TEST_CASE("a file that was cut short has all rows but the last") {
    const std::string one = csv_header() + csv_line(some_row()), two = one + csv_line(some_row());
    for (std::size_t length = one.size(); length < two.size(); ++length) {
        CHECK(read(two.substr(0, length)) == std::vector<Row>{some_row()});
    }
}

TEST_CASE("columns are told by their names, others are passed over, line ends may be of any system") {
    std::string header = "hair,";
    std::string line = "gray,";
    for (const Column& column : columns) {
        header = std::string(column.name) + "," + header;
        line = (column.name == "scene" ? "tree" : column.name == "rmse" ? "0.5" : "") + ("," + line);
    }
    const std::vector<Row> rows = read(header + "end\r\n" + line + "\r\n");
    REQUIRE(rows.size() == 1);
    CHECK(rows[0].scene == "tree");
    CHECK(rows[0].rmse == 0.5);
    CHECK_FALSE(rows[0].flip);
}

TEST_CASE("what is not a chart is refused") {
    CHECK_THROWS_AS(read(""), std::invalid_argument);
    CHECK_THROWS_AS(read("scene,rmse\ntree,0.5\n"), std::invalid_argument);
    CHECK_THROWS_AS(read(csv_header() + "tree,0.5\n"), std::invalid_argument);
    Row row = some_row();
    std::string line = csv_line(row);
    line.replace(line.find("-0.125"), 6, "1 in 8");
    CHECK_THROWS_AS(read(csv_header() + line), std::invalid_argument);
}

TEST_CASE("every column has a name and a meaning of its own") {
    for (const Column& column : columns) {
        CHECK_FALSE(column.name.empty());
        CHECK_FALSE(column.meaning.empty());
        CHECK(std::count_if(columns.begin(), columns.end(), [&](const Column& c) { return c.name == column.name; }) ==
              1);
    }
}
