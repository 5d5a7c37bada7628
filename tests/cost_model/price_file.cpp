#include "farfield/cost_model/price_file.hpp"

#include <cmath>

#include "catch.hpp"
#include "storage/files.hpp"

using namespace farfield;

namespace {

class PriceFile {
  public:
    std::filesystem::path path() const { return directory_ / "prices"; }

    std::string text() const {
        const Bytes bytes = read_file(path());
        return {bytes.begin(), bytes.end()};
    }
    /// What read_prices() says, after the file's name.
    std::string refusal(const std::string& text) const {
        write_file(path(), Bytes(text.begin(), text.end()));
        try {
            read_prices(path());
            return {};
        } catch (const std::runtime_error& e) {
            const std::string start = "farfield::read_prices: " + path().string() + ":", what = e.what();
            return what.substr(0, start.size()) == start ? what.substr(start.size()) : "NO NAME: " + what;
        }
    }

  private:
    TemporaryDirectory directory_;
};

const std::string good =
    "small_triangle 3\nnear_triangle 60\nface 60\nsplat 30\ncell 15\nrun 15\nimage 1000\ntexel 2\n";
std::string with_units(std::string text) {
    for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 13) {
        text.replace(at, 1, " nanoseconds\n");
    }
    return text;
}

}  // namespace

TEST_CASE("prices come back from their file to the last bit") {
    const PriceFile file;
    MeasuredTime prices;
    prices.small_triangle = 0.1f;
    prices.face = 1e-20f;
    prices.splat = 3.4e38f;
    prices.cell = std::nextafter(15.0f, 16.0f);
    write_prices(prices, file.path());
    const MeasuredTime back = read_prices(file.path());
    for (const auto& named : detail::named_prices) CHECK(back.*named.price == prices.*named.price);

    const std::string text = file.text();
    CHECK(text.find("small_triangle 0.1 nanoseconds\n") != std::string::npos);
    CHECK(text.front() == '#');
}

TEST_CASE("whatever people do to the file between lines is theirs") {
    const PriceFile file;
    CHECK(file.refusal(with_units(good)).empty());
    CHECK(file.refusal("\r\n# mine\r\n  \t\n" + with_units(good) + "#end").empty());
    std::string windows = with_units(good);
    for (std::size_t at = 0; (at = windows.find('\n', at)) != std::string::npos; at += 2) windows.insert(at, "\r");
    CHECK(file.refusal(windows).empty());
    CHECK(read_prices(file.path()).image == 1000);
}

TEST_CASE("files from before images had prices of their own are read, with defaults for those") {
    const PriceFile file;
    CHECK(file.refusal(with_units(good)).empty());
    CHECK(read_prices(file.path()).hit_triangle == MeasuredTime().hit_triangle);
    CHECK(read_prices(file.path()).made_texel == MeasuredTime().made_texel);
    CHECK(file.refusal(with_units(good + "made_image 7\nhit_triangle 20\n")).empty());
    CHECK(read_prices(file.path()).made_image == 7);
    CHECK(read_prices(file.path()).hit_triangle == 20);
    CHECK_FALSE(file.refusal(with_units(good + "made_image 7\nmade_image 7\n")).empty());
}

TEST_CASE("what is no price is refused, with its line") {
    const PriceFile file;
    const auto second_line = [&](const std::string& line) { return file.refusal("# prices\n" + line + "\n"); };
    CHECK(second_line("triangle 3 nanoseconds") == "2: 'triangle' is no kind of work");
    CHECK(second_line("face") == "2: expected a number after 'face', found ''");
    CHECK(second_line("face much nanoseconds") == "2: expected a number after 'face', found 'much'");
    CHECK(second_line("face 3,1 nanoseconds") == "2: expected a number after 'face', found '3,1'");
    CHECK(second_line("face 0 nanoseconds") == "2: a price must be above 0 and finite, not 0");
    CHECK(second_line("face -1 nanoseconds") == "2: a price must be above 0 and finite, not -1");
    CHECK(second_line("face nan nanoseconds") == "2: a price must be above 0 and finite, not nan");
    CHECK(second_line("face inf nanoseconds") == "2: a price must be above 0 and finite, not inf");
    CHECK(second_line("face 1e99 nanoseconds") == "2: a price must be above 0 and finite, not 1e99");
    CHECK(second_line("face 3") == "2: expected 'nanoseconds' after the price and nothing else");
    CHECK(second_line("face 3 microseconds") == "2: expected 'nanoseconds' after the price and nothing else");
    CHECK(second_line("face 3 nanoseconds each") == "2: expected 'nanoseconds' after the price and nothing else");
    CHECK(file.refusal("face 3 nanoseconds\nface 3 nanoseconds\n") == "2: the price of 'face' was given before");
    CHECK(file.refusal("") == " the price of 'small_triangle' is missing");
    CHECK(file.refusal(with_units(good.substr(0, good.find("texel")))) == " the price of 'texel' is missing");
}

TEST_CASE("files that cannot be opened are named") {
    const std::string nowhere = "/no/such/place/prices";
    CHECK_THROWS_WITH(read_prices(nowhere), "farfield::read_prices: " + nowhere + ": cannot be opened");
    CHECK_THROWS_WITH(write_prices({}, nowhere), "farfield::write_prices: " + nowhere + ": cannot be written");
    CHECK_THROWS_AS(read_prices(std::filesystem::temp_directory_path()), std::runtime_error);
}
