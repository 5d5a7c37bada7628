#include "embree_drawer.hpp"

#include <embree3/rtcore.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace farfield::bench {
namespace {

class Device {
  public:
    Device() : device_(rtcNewDevice("threads=1")) {
        if (device_ == nullptr) throw std::runtime_error("Embree cannot run here");
    }
    ~Device() { rtcReleaseDevice(device_); }
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;
    operator RTCDevice() const { return device_; }

  private:
    RTCDevice device_;
};

class EmbreeDrawer final : public Drawer {
  public:
    explicit EmbreeDrawer(std::span<const VertexColoredTriangle> triangles)
        : quadrilaterals_(quadrilaterals_of(triangles)), scene_(rtcNewScene(device_)) {
        rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
        RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_QUAD);
        const std::size_t count = quadrilaterals_.size();
        auto* const vertices = static_cast<glm::vec3*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(glm::vec3), 4 * count));
        auto* const corners = static_cast<unsigned*>(
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, 4 * sizeof(unsigned), count));
        for (std::size_t i = 0; i < 4 * count; ++i) {
            vertices[i] = quadrilaterals_[i / 4].vertices[i % 4];
            corners[i] = unsigned(i);
        }
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene_, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene_);
    }
    ~EmbreeDrawer() override { rtcReleaseScene(scene_); }

    FrameStats frame(const View& view) override {
        image_ = Image(view.width, view.height);
        for (int y = 0; y < view.height; ++y) {
            for (int x = 0; x < view.width; ++x) image_.at(x, y) = pixel(view, x, y);
        }
        return {};
    }
    const Image& image() const override { return image_; }

  private:
    Rgba8 pixel(const View& view, int x, int y) const {
        unsigned sums[4] = {32, 32, 32, 32};
        for (int packet = 0; packet < 4; ++packet) {
            alignas(64) RTCRayHit16 rays;
            const Camera& camera = view.camera;
            // 4 x 4 samples next to each other.
            const float step = 2 * camera.half_height / float(8 * view.height);
            const float left = (float(8 * x + 4 * (packet % 2)) + 0.5f - 4 * float(view.width)) * step;
            const float top = (4 * float(view.height) - float(8 * y + 4 * (packet / 2)) - 0.5f) * step;
            const glm::vec3 eye(camera.eye);
            const glm::vec3 first = camera.forward + left * camera.right + top * camera.up;
            const glm::vec3 right = step * camera.right, down = -step * camera.up;
            for (int k = 0; k < 16; ++k) {
                const float i = float(k % 4), j = float(k / 4);
                rays.ray.org_x[k] = eye.x;
                rays.ray.org_y[k] = eye.y;
                rays.ray.org_z[k] = eye.z;
                rays.ray.dir_x[k] = first.x + i * right.x + j * down.x;
                rays.ray.dir_y[k] = first.y + i * right.y + j * down.y;
                rays.ray.dir_z[k] = first.z + i * right.z + j * down.z;
                rays.ray.tnear[k] = 0;
                rays.ray.tfar[k] = std::numeric_limits<float>::infinity();
                rays.ray.time[k] = 0;
                rays.ray.mask[k] = ~0u;
                rays.ray.flags[k] = 0;
                rays.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
                rays.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
            }
            alignas(64) static constexpr int all[16] = {-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1};
            RTCIntersectContext context;
            rtcInitIntersectContext(&context);
            context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
            rtcIntersect16(all, scene_, &context, &rays);
            for (int k = 0; k < 16; ++k) {
                if (rays.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) continue;
                const Rgba8 c = quadrilaterals_[rays.hit.primID[k]].rgba;
                sums[0] += c.r, sums[1] += c.g, sums[2] += c.b, sums[3] += c.a;
            }
        }
        return {std::uint8_t(sums[0] >> 6), std::uint8_t(sums[1] >> 6), std::uint8_t(sums[2] >> 6),
                std::uint8_t(sums[3] >> 6)};
    }

    std::vector<Quadrilateral> quadrilaterals_;
    Device device_;
    RTCScene scene_;
    Image image_;
};

}  // namespace

std::unique_ptr<Drawer> embree_drawer(std::span<const VertexColoredTriangle> pairs_of_triangles) {
    return std::make_unique<EmbreeDrawer>(pairs_of_triangles);
}

std::string embree_name() {
    const Device device;
    const auto version = rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION);
    const bool is_native = rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) != 0;
    return "Embree " + std::to_string(version / 10000) + "." + std::to_string(version / 100 % 100) + "." +
           std::to_string(version % 100) + (is_native ? ", packets of 16" : ", packets of 16 in parts");
}

}  // namespace farfield::bench
