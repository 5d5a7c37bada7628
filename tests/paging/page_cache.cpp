#include "farfield/paging/page_cache.hpp"

#include "catch.hpp"

using namespace farfield;
