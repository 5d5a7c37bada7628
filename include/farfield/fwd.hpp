// Names without definitions, for headers that only mention them.
#pragma once

namespace farfield {

template <class T>
struct BasicBox;
template <class T>
struct BasicPolygon;
struct Rgba8;
struct Triangle;
struct VertexColoredTriangle;
struct Similarity;
struct DirectionalLight;
class GridSampler;

struct Camera;
struct View;
struct LocalView;
struct FrameStats;
struct Cell;
struct Work;

template <class P>
struct primitive_traits;
template <class H, class P>
struct Instance;

enum Assignment : unsigned;
template <Assignment assigned>
struct BasicOctree;
struct PolygonBsp;
struct Exact;
struct ColorCube;
struct OpacityTensor;
struct TriangleCount;
struct MeasuredTime;

struct BuildOptions;
struct BuildReport;

class Image;
struct ZBufferOptions;
class ZBufferRenderer;
class HierarchicalZRenderer;
class PainterRenderer;
struct CoverageOptions;
template <class Traits>
class BasicCoverageRenderer;
struct LazyCoverage;
struct StrictCoverage;
class VoxelPyramid;

}  // namespace farfield
