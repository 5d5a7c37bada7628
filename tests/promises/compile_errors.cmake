# Small programs that miss something: compilers name it in their first 20 lines. Run by ctest:
#
#     cmake -DSOURCE_DIRECTORY=... -DDIRECTORY=... -DCOMPILER=... -P compile_errors.cmake
#
# COMPILER is the project's; g++ and clang++ are tried too, where they are installed.
cmake_minimum_required(VERSION 3.20)

set(compilers "${COMPILER}")
foreach(name g++ clang++)
  find_program(found_${name} ${name})
  if(found_${name})
    list(APPEND compilers "${found_${name}}")
  endif()
endforeach()
list(REMOVE_DUPLICATES compilers)
file(MAKE_DIRECTORY "${DIRECTORY}")

# The headers are parsed once for each compiler, which takes longer than all programs. Both compilers take a precompiled
# NAME.gch for `-include NAME`.
set(includes)
foreach(header approximation/color_cube approximation/exact partition/octree partition/polygon_bsp
               cost_model/triangle_count primitive/triangle build viewer
               paging/open_pages paging/write_pages primitive/instance)
  string(APPEND includes "#include \"farfield/${header}.hpp\"\n")
endforeach()
set(options -std=c++20 "-I${SOURCE_DIRECTORY}/include")
foreach(compiler IN LISTS compilers)
  get_filename_component(name "${compiler}" NAME)
  set(headers "${DIRECTORY}/${name}.hpp")
  file(WRITE "${headers}" "${includes}")
  execute_process(COMMAND "${compiler}" ${options} -x c++-header "${headers}" -o "${headers}.gch"
                  RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${compiler} does not take the headers")
  endif()
  list(APPEND headers_of_compilers "${headers}")
endforeach()

# Every line of the text must come up in the first 20 lines of errors that the program gives.
function(expect name text program)
  set(source "${DIRECTORY}/${name}.cpp")
  file(WRITE "${source}" "using namespace farfield;\n${program}\n")
  foreach(compiler headers IN ZIP_LISTS compilers headers_of_compilers)
    execute_process(COMMAND "${compiler}" ${options} -fsyntax-only -include "${headers}" "${source}"
                    RESULT_VARIABLE result OUTPUT_QUIET ERROR_VARIABLE errors)
    if(result EQUAL 0)
      message(SEND_ERROR "${compiler} takes ${source}")
      continue()
    endif()
    string(REPLACE ";" "," errors "${errors}") # lines are a list from here on
    string(REPLACE "[" "(" errors "${errors}")
    string(REPLACE "]" ")" errors "${errors}")
    string(REPLACE "\n" ";" lines "${errors}")
    list(LENGTH lines count)
    if(count GREATER 20)
      list(SUBLIST lines 0 20 lines)
    endif()
    string(REPLACE ";" "\n" head "${lines}")
    foreach(wanted IN LISTS text)
      string(FIND "${head}" "${wanted}" at)
      if(at EQUAL -1)
        message(SEND_ERROR "${compiler} does not say '${wanted}' of ${source}:\n${head}")
      endif()
    endforeach()
  endforeach()
endfunction()

set(triangles "int main() { std::vector<Triangle> triangles;")
set(cubes "using Cubes = SpatialHierarchy<Octree, ColorCube, TriangleCount>;")

# --- approximations: a flag without its hook, one after the other

set(whole "
struct Whole {
    struct stand_in_data { int x; };
    struct stand_in_draft {};
    static constexpr ApproximationFacts facts{.stands_in = true, FLAGS};
    HOOKS
};
using H = SpatialHierarchy<Octree, Whole, TriangleCount>;
${triangles} build<H>(triangles); }")
set(sample "stand_in_draft sample(const Cell&, auto&&, auto&) const { return {}@ }")
set(work "Work expected_work() const { return {}@ }")
set(error "float error_px(const stand_in_data&, const Cell&, const LocalView&) const { return 1@ }")
set(finish "stand_in_data finish(const Cell&, const stand_in_draft&) const { return {}@ }")
set(draw "void draw_stand_in(const stand_in_data&, const Cell&, const LocalView&, auto&&) const {}")
function(expect_of_approximation name text flags)
  string(REPLACE "FLAGS" "${flags}" program "${whole}")
  string(REPLACE ";" " " hooks "${ARGN}")
  string(REPLACE "@" ";" hooks "${hooks}") # which would end an element of a list
  string(REPLACE "HOOKS" "${hooks}" program "${program}")
  expect("${name}" "${text}" "${program}")
endfunction()
expect_of_approximation(no_sample "sample(const Cell&" "" ${work} ${error} ${finish} ${draw})
expect_of_approximation(no_expected_work "expected_work()" "" ${sample} ${error} ${finish} ${draw})
expect_of_approximation(no_error_px "float error_px(" "" ${sample} ${work} ${finish} ${draw})
expect_of_approximation(no_finish "finish(const Cell&" "" ${sample} ${work} ${error} ${draw})
expect_of_approximation(no_draw_stand_in "draw_stand_in(" "" ${sample} ${work} ${error} ${finish})
set(five ${sample} ${work} ${error} ${finish} ${draw})
expect_of_approximation(no_least_error_px "float least_error_px(" ".bounds_error = true" ${five})
expect_of_approximation(no_area_law "area_law(const" ".provides_area_law = true" ${five})
expect_of_approximation(no_expected_rmse "float expected_rmse(float" ".expects_error = true" ${five})
expect_of_approximation(no_reproduces "bool reproduces(" ".compares = true" ${five})
expect_of_approximation(no_merge "merge(const Cell&" ".merges_octants = true" ${five})
expect_of_approximation(no_sample_key "float sample_key(" ".samples_primitives = true" ${five})
expect_of_approximation(no_pool_element "pool_element" ".has_pool = true" ${five})
expect_of_approximation(wrong_stand_in_work "Work work(const stand_in_data&)" "" ${five}
                        "float work(const stand_in_data&) const { return 1@ }")
expect_of_approximation(misspelt_stand_in_polygons "`polygons` is what is meant" "" ${five}
                        "void polygon(const stand_in_data&, const Cell&, auto&&) const {}")

# --- partitions and cost models

expect(no_front_to_back "front_to_back("
       "struct Flat { struct node_data {}; static constexpr PartitionFacts facts{};
          Cell root(const Box&) const { return {}; }
          Cell child(const Cell& c, const node_data&, unsigned) const { return c; }
          Split choose(const Cell&, std::span<const Item>, node_data&) const { return Split::no; }
          void place(const Cell&, const node_data&, const Item&, auto&&, auto&& emit) const { emit.keep(); } };
        using H = SpatialHierarchy<Flat, Exact, TriangleCount>;
        ${triangles} build<H>(triangles); }")
expect(no_fit "void fit(const Cell&"
       "struct Cuts2 : PolygonBsp { void fit() const {} };
        using H = SpatialHierarchy<Cuts2, Exact, TriangleCount>;
        ${triangles} build<H>(triangles); }")
expect(no_cost "float cost(const Work&)"
       "struct Free { static constexpr const char* unit = \"\"; static constexpr std::uint32_t file_tag = 0; };
        using H = SpatialHierarchy<Octree, Exact, Free>;
        ${triangles} build<H>(triangles); }")

# --- primitives

set(box "struct Thing { Box bounds() const { return {}; } ")
set(things "}; int main() { std::vector<Thing> things; build<Cubes>(things); }")
set(polygons "void polygons(auto&&) const {} ")
expect(no_bounds "bounds" "${cubes} struct Thing { ${things}")
expect(no_polygons "polygons(Sink&& sink)" "${cubes} ${box} ${things}")
expect(misspelt_polygons "`polygons` is what is meant" "${cubes} ${box} void polygon(auto&&) const {} ${things}")
expect(polygons_that_change "polygons(Sink&& sink) const" "${cubes} ${box} void polygons(auto&&) {} ${things}")
expect(wrong_work "`Work work() const`" "${cubes} ${box} ${polygons} int work() const { return 1; } ${things}")
expect(wrong_color "`glm::vec4 color() const`"
       "${cubes} ${box} ${polygons} const char* color() const { return nullptr; } ${things}")
expect(wrong_visit_instance "bool visit_instance(F&& f)"
       "${cubes} ${box} ${polygons} void visit_instance(auto&&) const {} ${things}")
expect(wrong_key "`std::uint32_t key() const`"
       "${cubes} ${box} ${polygons} const char* key() const { return nullptr; } ${things}")

# --- sources of primitives

set(source "struct Mesh { std::size_t primitive_count() const { return 0; } ")
set(sources "}; int main() { Mesh mesh; build<Cubes>(mesh); }")
set(box "Box bounds(std::uint32_t) const { return {}; } ")
set(polygons "void polygons(std::uint32_t, auto&&) const {} ")
expect(no_source_bounds "Box bounds(std::uint32_t i) const" "${cubes} ${source} ${polygons} ${sources}")
expect(no_source_polygons "polygons(Sink&& sink)" "${cubes} ${source} ${box} ${sources}")
expect(polygons_without_sink "polygons(std::uint32_t i, Sink&& sink)"
       "${cubes} ${source} ${box} void polygons(std::uint32_t) const {} ${sources}")
expect(wrong_source_key "`std::uint32_t key(std::uint32_t i) const`"
       "${cubes} ${source} ${box} ${polygons} int key(std::uint32_t) const { return 1; } ${sources}")
expect(wrong_source_work "`Work work(std::uint32_t i) const`"
       "${cubes} ${source} ${box} ${polygons} Work work() const { return {}; } ${sources}")

# --- samplers, and what is built

expect(wrong_brightness "float brightness("
       "${cubes} struct Sampler { void sample(const SampleGrid&, auto&&, std::span<Rgba8>) {}
          const char* brightness(const Polygon&, glm::vec3) const { return nullptr; } };
        ${triangles} build<Cubes>(triangles, BuildOptions<Cubes, Sampler>{}); }")
expect(wrong_paint "paint(const Polygon&, const Box& seen, float finest, Sink&& sink) const"
       "${cubes} struct Sampler : GridSampler { void paint(const Polygon&, auto&&) const {} };
        ${triangles} build<Cubes>(triangles, BuildOptions<Cubes, Sampler>{}); }")
expect(paint_of_pieces "needs a partition that does not cut polygons"
       "struct Sampler : GridSampler { void paint(const Polygon&, const Box&, float, auto&&) const {} };
        using H = SpatialHierarchy<PolygonBsp, ColorCube, TriangleCount>;
        ${triangles} build<H>(triangles, BuildOptions<H, Sampler>{}); }")
expect(no_hierarchy "build<SpatialHierarchy<Octree, OpacityTensor, TriangleCount>>(primitives)"
       "${triangles} auto h = build(triangles); }")

# --- what cannot be done in pages

expect(no_stand_ins_in_pages "what is drawn while a page is missing is a stand-in"
       "using H = SpatialHierarchy<Octree, Exact, TriangleCount>;
        ${triangles} save_pages<H, Triangle>(build<H>(triangles), triangles, \"x\"); }")
expect(no_pages_of_instances "an instance borrows its hierarchy"
       "${cubes} int main() { open_pages<Cubes, Instance<Cubes, Triangle>>(\"x\"); }")

# --- renderers: a flag without its hook, one after the other

set(frames "void begin_frame(const LocalView&) {} void set_view(const LocalView&) {} void end_frame() {} ")
set(runs "void draw(const auto&, std::span<const Range>) {} ")
set(viewer "}; int main() { std::vector<Triangle> triangles; const auto h = build<Exactly>(triangles); Own r;
            auto v = make_viewer(h, triangles, r); }")
function(expect_of_renderer name text flags hooks)
  expect("${name}" "${text}"
         "using Exactly = SpatialHierarchy<Octree, Exact, TriangleCount>;
          struct Own { static constexpr RendererFacts facts{${flags}}; ${hooks} ${viewer}")
endfunction()
expect_of_renderer(no_end_frame "void end_frame()" ""
                   "void begin_frame(const LocalView&) {} void set_view(const LocalView&) {} ${runs}")
expect_of_renderer(no_draw "draw(const Source<P>&" "" "${frames}")
expect_of_renderer(no_upload "upload(const Source<P>&)" ".keeps_sources = true" "${frames} ${runs}")
expect_of_renderer(no_lifetime "lifetime() const" ".tells_lifetime = true" "${frames} ${runs}")
expect_of_renderer(no_light "light() const" ".tells_light = true" "${frames} ${runs}")
expect_of_renderer(no_faces "draw(std::span<const Face>)" ".draws_faces = true" "${frames} ${runs}")
expect_of_renderer(no_placed "draw(const PlacedStandIns&)" ".draws_splats = true, .shapes_stand_ins = true"
                   "${frames} ${runs} void draw(std::span<const Splat>) {} float largest_splat_px() const { return 2; }")
expect_of_renderer(no_splats "draw(std::span<const Splat>)" ".draws_splats = true" "${frames} ${runs}")
expect_of_renderer(no_frame_polygons "draw(std::span<const Polygon>)" ".draws_polygons = true" "${frames} ${runs}")
expect_of_renderer(no_hidden "bool hidden(" ".answers_hidden = true" "${frames} ${runs}")
expect_of_renderer(no_deposits "bool deposits_primitives()" ".deposits_primitives = true" "${frames} ${runs}")
expect(no_faces_for_cubes "needs a renderer with `draws_faces`"
       "${cubes} struct Own { static constexpr RendererFacts facts{}; ${frames} ${runs} };
        ${triangles} const auto h = build<Cubes>(triangles); Own r; auto v = make_viewer(h, triangles, r); }")
