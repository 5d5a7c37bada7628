#include "farfield/paging/page_slots.hpp"

#include "catch.hpp"

using namespace farfield;
