// Google Draco's k-d tree coder: draco QUANTIZATION_BITS COMPRESSION_LEVEL SCAN CLOUD RUNS. Positions only.
#include "cost.hpp"

#include <draco/compression/decode.h>
#include <draco/compression/encode.h>
#include <draco/point_cloud/point_cloud_builder.h>

namespace {

std::unique_ptr<draco::PointCloud> to_draco(const std::vector<Point>& points) {
  draco::PointCloudBuilder builder;
  builder.Start(static_cast<draco::PointIndex::ValueType>(points.size()));
  const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  builder.SetAttributeValuesForAllPoints(position, points.data(), sizeof(Point));
  return builder.Finalize(false);
}

std::vector<Point> from_draco(const draco::PointCloud& cloud) {
  const auto* position = cloud.GetNamedAttribute(draco::GeometryAttribute::POSITION);
  std::vector<Point> points(cloud.num_points());
  for (draco::PointIndex index(0); index < cloud.num_points(); ++index) {
    float xyz[3];
    position->GetMappedValue(index, xyz);
    points[index.value()] = {xyz[0], xyz[1], xyz[2], 0};
  }
  return points;
}

void check(const draco::Status& status) {
  if (!status.ok()) throw std::runtime_error(status.error_msg_string());
}

}  // namespace

int main(int count, char** words) try {
  if (count != 6) throw std::runtime_error("usage: draco QUANTIZATION_BITS COMPRESSION_LEVEL SCAN CLOUD RUNS");
  const int bits = std::stoi(words[1]), speed = 10 - std::stoi(words[2]), runs = std::stoi(words[5]);
  const auto points = read_cloud(words[3]);
  draco::EncoderBuffer coded;
  // Into its own kind of cloud and back counts: a user has points, and wants points.
  const Cost encode = measure(runs, [&] {
    const auto cloud = to_draco(points);
    draco::Encoder encoder;
    encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, bits);
    encoder.SetSpeedOptions(speed, speed);
    encoder.SetEncodingMethod(draco::POINT_CLOUD_KD_TREE_ENCODING);
    coded.Clear();
    check(encoder.EncodePointCloudToBuffer(*cloud, &coded));
  });
  std::vector<Point> decoded;
  const Cost decode = measure(runs, [&] {
    draco::DecoderBuffer buffer;
    buffer.Init(coded.data(), coded.size());
    draco::Decoder decoder;
    auto cloud = decoder.DecodePointCloudFromBuffer(&buffer);
    check(cloud.status());
    decoded = from_draco(*cloud.value());
  });
  write_cloud(words[4], decoded);
  print_codec(coded.size(), encode, decode);
} catch (const std::exception& error) {
  std::cerr << "draco: " << error.what() << "\n";
  return 1;
}
