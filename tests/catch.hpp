// Catch2 under either of its two interfaces: one header in version 2 (what Debian 12 has), many in version 3.
// Both bring their own main in the target Catch2::Catch2WithMain.
#pragma once

#if __has_include(<catch2/catch_test_macros.hpp>)
#include <catch2/catch_approx.hpp>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators_all.hpp>
#include <catch2/matchers/catch_matchers_all.hpp>
using Catch::Approx;  // version 2 has it outside of the namespace already
#else
#include <catch2/catch.hpp>
#endif
