// The Point Cloud Library: its octree codec, and what building each intermediate representation takes.
//   pcl codec low|medium|high SCAN CLOUD RUNS
//   pcl construct SCAN RUNS
#include "cost.hpp"

#include <sstream>

#include <pcl/common/io.h>
#include <pcl/compression/octree_pointcloud_compression.h>
#include <pcl/io/impl/entropy_range_coder.hpp>
#include <pcl/io/impl/octree_pointcloud_compression.hpp>
#include <pcl/features/normal_3d.h>
#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/octree/octree_search.h>
#include <pcl/point_types.h>
#include <pcl/range_image/range_image_spherical.h>
#include <pcl/search/kdtree.h>
#include <pcl/surface/gp3.h>

namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

Cloud::Ptr to_pcl(const std::vector<Point>& points) {
  auto cloud = pcl::make_shared<Cloud>();
  cloud->reserve(points.size());
  for (const auto& point : points) cloud->push_back({point.x, point.y, point.z});
  return cloud;
}

pcl::io::compression_Profiles_e profile(const std::string& name) {
  if (name == "low") return pcl::io::LOW_RES_ONLINE_COMPRESSION_WITHOUT_COLOR;
  if (name == "medium") return pcl::io::MED_RES_ONLINE_COMPRESSION_WITHOUT_COLOR;
  if (name == "high") return pcl::io::HIGH_RES_ONLINE_COMPRESSION_WITHOUT_COLOR;
  throw std::runtime_error("no profile " + name);
}

// As its own example does it, without thinning the points out. Each scan for itself: a new coder for each, so that no frame is coded against the last.
void codec(const std::string& name, const char* scan, const char* out, int runs) {
  using Codec = pcl::io::OctreePointCloudCompression<pcl::PointXYZ>;
  const auto cloud = to_pcl(read_cloud(scan));
  std::string coded;
  const Cost encode = measure(runs, [&] {
    std::ostringstream stream;
    Codec codec(profile(name), false);
    codec.encodePointCloud(cloud, stream);
    coded = stream.str();
  });
  auto decoded = pcl::make_shared<Cloud>();
  const Cost decode = measure(runs, [&] {
    std::istringstream stream(coded);
    Codec codec(profile(name), false);
    codec.decodePointCloud(stream, decoded);
  });
  std::vector<Point> points;
  for (const auto& point : *decoded) points.push_back({point.x, point.y, point.z, 0});
  write_cloud(out, points);
  print_codec(coded.size(), encode, decode);
}

// Marton's greedy projection triangulation, as the paper's; the normals that it needs belong to it.
void triangulate(const Cloud::Ptr& cloud) {
  auto tree = pcl::make_shared<pcl::search::KdTree<pcl::PointXYZ>>();
  tree->setInputCloud(cloud);
  pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
  estimation.setInputCloud(cloud);
  estimation.setSearchMethod(tree);
  estimation.setKSearch(20);
  pcl::PointCloud<pcl::Normal> normals;
  estimation.compute(normals);
  auto oriented = pcl::make_shared<pcl::PointCloud<pcl::PointNormal>>();
  pcl::concatenateFields(*cloud, normals, *oriented);
  auto oriented_tree = pcl::make_shared<pcl::search::KdTree<pcl::PointNormal>>();
  oriented_tree->setInputCloud(oriented);
  pcl::GreedyProjectionTriangulation<pcl::PointNormal> greedy;
  greedy.setSearchRadius(1.0);
  greedy.setMu(2.5);
  greedy.setMaximumNearestNeighbors(100);
  greedy.setMaximumSurfaceAngle(M_PI / 4);
  greedy.setMinimumAngle(M_PI / 18);
  greedy.setMaximumAngle(2 * M_PI / 3);
  greedy.setNormalConsistency(false);
  greedy.setInputCloud(oriented);
  greedy.setSearchMethod(oriented_tree);
  pcl::PolygonMesh mesh;
  greedy.reconstruct(mesh);
}

void construct(const char* scan, int runs) {
  const auto cloud = to_pcl(read_cloud(scan));
  const Cost octree = measure(runs, [&] {
    pcl::octree::OctreePointCloudSearch<pcl::PointXYZ> tree(0.01);
    tree.setInputCloud(cloud);
    tree.addPointsFromInputCloud();
  });
  const Cost kd_tree = measure(runs, [&] {
    pcl::KdTreeFLANN<pcl::PointXYZ> tree;
    tree.setInputCloud(cloud);
  });
  const Cost range_image = measure(runs, [&] {
    pcl::RangeImageSpherical image;
    const auto step = static_cast<float>(2 * M_PI / 4500);
    image.createFromPointCloud(*cloud, step, static_cast<float>(0.4187 * M_PI / 180), static_cast<float>(2 * M_PI),
                               static_cast<float>(26.8 * M_PI / 180), Eigen::Affine3f::Identity());
  });
  // Seconds a run: one tells.
  const Cost mesh = measure(1, [&] { triangulate(cloud); });
  std::cout << "{\"octree\":" << octree << ",\"kd_tree\":" << kd_tree << ",\"range_image\":" << range_image
            << ",\"mesh\":" << mesh << "}\n";
}

}  // namespace

int main(int count, char** words) try {
  const std::vector<std::string> arguments(words + 1, words + count);
  if (count == 6 && arguments[0] == "codec") {
    codec(arguments[1], words[3], words[4], std::stoi(arguments[4]));
  } else if (count == 4 && arguments[0] == "construct") {
    construct(words[2], std::stoi(arguments[2]));
  } else {
    throw std::runtime_error("usage: pcl codec low|medium|high SCAN CLOUD RUNS | pcl construct SCAN RUNS");
  }
} catch (const std::exception& error) {
  std::cerr << "pcl: " << error.what() << "\n";
  return 1;
}
