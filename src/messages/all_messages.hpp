#pragma once

#include "loopstone/messages/message_types.hpp"

/// X(M) for every message M that can be a topic's type or part of one: what the templates of
/// message_codec.hpp are instantiated for.
// clang-format off
#define LOOPSTONE_ALL_MESSAGES(X)                                                          \
  X(Header) X(Vector3) X(Point) X(Quaternion) X(Pose) X(PoseWithCovariance) X(Twist)       \
  X(TwistWithCovariance) X(Transform) X(PoseStamped) X(PoseWithCovarianceStamped)          \
  X(TransformStamped) X(TFMessage) X(LaserScan) X(LaserEcho) X(MultiEchoLaserScan)         \
  X(PointField) X(PointCloud2) X(Imu) X(JointState) X(Image) X(CompressedImage)            \
  X(RegionOfInterest) X(CameraInfo) X(Odometry) X(MapMetaData) X(OccupancyGrid) X(Path)    \
  X(String) X(ColorRGBA) X(Clock) X(Marker) X(MarkerArray) X(KeyValue) X(DiagnosticStatus) \
  X(DiagnosticArray) X(WheelTicks) X(PoseArray) X(MapTiles) X(Trajectory)
// clang-format on
