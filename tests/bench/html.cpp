#include "../../bench/accuracy/chart/html.cpp"

#include <algorithm>
#include <filesystem>
#include <limits>
#include <sstream>
#include <string>

#include "catch.hpp"

using namespace farfield::bench;

namespace {

const std::string hostile = "</script><b>&\"'\\\n<!--";

Row measured(std::string scene, std::string variant, double samples, Row::Number tolerance_px) {
    Row row;
    row.chart = "accuracy";
    row.scene = std::move(scene);
    row.view = "7 radii";
    row.variant = std::move(variant);
    row.samples = samples;
    row.tolerance_px = tolerance_px;
    row.speedup = tolerance_px.value_or(1 / samples);
    row.time_ms = 10 / *row.speedup;
    row.rmse = row.flip = 0.08 / samples;
    return row;
}

std::vector<Row> some_rows() {
    std::vector<Row> rows;
    for (const char* scene : {"tree", "forest", "island"}) {
        rows.push_back(measured(scene, "exact", 1, {}));
        for (int v = 0; v < 12; ++v) rows.push_back(measured(scene, "v" + std::to_string(v), 1, 2 + v));
    }
    return rows;
}

std::string page(const std::vector<Row>& rows, const std::filesystem::path& directory = "no_such_directory") {
    std::ostringstream out;
    write_html(out, rows, charts_of(rows), directory);
    return out.str();
}

/// Elements that are open after the text; what is wrong, if anything, comes last. Attributes are in double quotes, and
/// nothing is implied.
std::vector<std::string> open_elements(const std::string& html) {
    const std::vector<std::string> without_end{"meta", "img", "!DOCTYPE"};
    std::vector<std::string> open;
    for (std::size_t at = html.find('<'); at != std::string::npos; at = html.find('<', at)) {
        std::size_t end = at;
        for (bool in_quotes = false; end < html.size() && (in_quotes || html[end] != '>'); ++end) {
            if (html[end] == '"') in_quotes = !in_quotes;
        }
        const bool is_end = html[at + 1] == '/';
        const std::size_t from = at + (is_end ? 2 : 1);
        const std::string name = html.substr(from, html.find_first_of(" >\n", from) - from);
        at = end;
        if (is_end) {
            if (open.empty() || open.back() != name) {
                open.push_back("/" + name);
                return open;
            }
            open.pop_back();
        } else if (std::find(without_end.begin(), without_end.end(), name) == without_end.end()) {
            open.push_back(name);
            if (name == "script" || name == "style") at = html.find("</" + name, at);
        }
    }
    return open;
}

/// What the script reads.
std::string data_of(const std::string& html) {
    const std::size_t from = html.find("id=\"data\">") + 10;
    return html.substr(from, html.find("</script", from) - from);
}

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("the page is well-formed, whatever scenes and variants are called") {
    CHECK(open_elements("<p><b></p></b>") == std::vector<std::string>{"p", "b", "/p"});
    CHECK(open_elements(page(some_rows())).empty());
    CHECK(open_elements(page({measured(hostile, "exact", 1, {}), measured(hostile, hostile, 1, 2)})).empty());
    CHECK(open_elements(page({})).empty());
}

TEST_CASE("the page has every scene and variant, to be switched on, and the table at equal error first") {
    const std::string html = page(some_rows()), data = data_of(html);
    for (const char* scene : {"tree", "forest", "island"}) CHECK(has(data, "\"" + std::string(scene) + "\""));
    for (int v = 0; v < 12; ++v) {
        CHECK(has(data, "\"v" + std::to_string(v) + "\""));
        CHECK(has(html, "<th>v" + std::to_string(v) + "</th>"));
    }
    CHECK(html.find("<table>") < html.find("id=\"plot\""));
    CHECK(html.find("At equal error: RMSE") < html.find("At equal error: FLIP"));
    CHECK(std::count(data.begin(), data.end(), '\n') == 2 + 3 * 13);  // columns, what is shown at first, a line a row
    // At first those of the chart at a glance: exact and the four fastest.
    CHECK(has(data, "\"shown\":[\"exact\",\"v11\",\"v10\",\"v9\",\"v8\"]"));
}

TEST_CASE("the page needs no network") {
    const std::string html = page(some_rows());
    for (const char* part : {"http:", "https:", "//cdn", "src=\"//", "@import", "fetch(", "XMLHttpRequest"}) {
        CHECK_FALSE(has(html, part));
    }
}

TEST_CASE("names of scenes and variants do not become elements, nor end the script") {
    const std::string html = page({measured("tree", "exact", 1, {}), measured("tree", hostile, 1, 2)});
    CHECK_FALSE(has(html, "<b>&"));
    CHECK(has(html, "<th>&lt;/script>&lt;b>&amp;&quot;'\\\n&lt;!--</th>"));
    CHECK(has(data_of(html), "\"\\u003c/script>\\u003cb>&\\u0022'\\u005c\\u000a\\u003c!--\""));
    CHECK(has(html, "<meta charset=\"utf-8\">"));
}

TEST_CASE("numbers that JSON has no word for are none") {
    std::vector<Row> rows{measured("tree", "exact", 1, {}), measured("tree", "cube", 1, 2)};
    rows[1].rmse = std::numeric_limits<double>::quiet_NaN();
    rows[1].flip = std::numeric_limits<double>::infinity();
    const std::string data = data_of(page(rows));
    CHECK_FALSE(has(data, "nan"));
    CHECK_FALSE(has(data, "inf"));
}

TEST_CASE("cells of the table lead to their points") {
    const std::vector<Row> rows{measured("tree", "exact", 1, {}), measured("tree", "cube", 1, 2)};
    CHECK(has(page(rows), "<td><button type=\"button\" data-row=\"1\">2 px: 5 ms, 2x</button></td>"));
}

TEST_CASE("a point has its picture where that lies beside the page, by an address that needs no escapes") {
    const std::vector<Row> rows{measured("tree", "exact", 1, {}), measured("tree", "a#b%+c", 1, 0.5)};
    const std::filesystem::path file = point_picture_file(rows[1]), reference = point_reference_file(rows[1]);
    CHECK(file.generic_string() == "pictures/points/tree_7_radii_a_b__c_1_0.5.png");
    CHECK(reference == point_reference_file(rows[0]));
    CHECK_FALSE(has(data_of(page(rows)), ".png"));
    const std::filesystem::path directory = std::filesystem::temp_directory_path() / "farfield_test_page";
    std::filesystem::create_directories(directory / file.parent_path());
    std::ofstream(directory / file) << "a picture";
    const std::string data = data_of(page(rows, directory));
    std::filesystem::remove_all(directory);
    CHECK(has(data, "\"" + file.generic_string() + "\",null]"));
    CHECK(has(data, ",null,null]"));
}
