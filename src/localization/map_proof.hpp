#pragma once

namespace loopstone {

/// Whether the map has been borne out. A robot that drove for metres on a map and found no place
/// that fits is probably not in this building, and the next place that fits is probably one more
/// that is only similar. Once a place has held for long the map is known to be the right one, and
/// whatever happens later says nothing against it.
class MapProof {
 public:
  /// Doubt in the map, [0, 1]: 0 at the start, and for ever once the map is proven; 1 where the
  /// robot has driven far in vain and nothing holds.
  /// \param travelled_m  path since the first scan
  /// \param fits         scans fit the map from the most probable place, whatever was before
  /// \param followed_m   path over which that place has been the most probable one
  double doubt_at(double travelled_m, bool fits, double followed_m);

  /// Somebody says where the robot is: what was driven in vain does not count.
  void begin_anew() { in_vain_m_ = 0.0; }

 private:
  double last_m_ = 0.0;
  double in_vain_m_ = 0.0;  ///< driven where no place fitted
  double held_m_ = 0.0;     ///< driven along a place that fits
  bool proven_ = false;
};

}  // namespace loopstone
