"""The options of every call, with their defaults, rules and meaning.

Written by scripts/write_python_options.py from the descriptions that the program's flags and files
have: `loopstone config` shows the same.
"""

from __future__ import annotations

from dataclasses import dataclass
from dataclasses import field as _field
from typing import ClassVar, Literal

from ._option_group import CallOptions, OptionGroup


@dataclass(kw_only=True, slots=True)
class MapFrontEndOptions(OptionGroup):
    """The group ``front_end``."""

    range_max_m: float = 60.0
    """farther returns are not used for matching (a number from 0.5 to 1000)"""
    points_max: int = 360
    """points of a scan that are matched, after thinning (a whole number from 20 to 10000)"""
    key_distance_m: float = 0.15
    """a key scan after so much travel (a number from 0.01 to 5)"""
    key_angle_rad: float = 0.12
    """or after so much turning (a number from 0.01 to 3.2)"""
    submap_length_m: float = 8.0
    """travel that fills a submap; the next one starts at half of it (a number from 0.5 to 100)"""
    trusted_score: float = 0.6
    """a match that explains less of the scan is checked by a search (a number from 0 to 1)"""
    search_half_xy_m: float = 0.6
    """half side of the window of that search (a number from 0.1 to 10)"""
    search_half_yaw_rad: float = 0.5
    """half heading range of that search (a number from 0.01 to 3.2)"""
    odometry: Literal["check", "trust", "ignore"] = "check"
    """used while it agrees with the laser, used always, or not at all"""


@dataclass(kw_only=True, slots=True)
class MapMatchOptions(OptionGroup):
    """The group ``match``."""

    max_iterations: int = 15
    """Gauss-Newton steps on each level (a whole number from 1 to 200)"""
    kernel_width_m: float = 0.04
    """distances beyond this count less and less (Cauchy kernel); on coarser levels in proportion
    to the cell (a number from 0.001 to 1)
    """
    residual_sigma_m: float = 0.04
    """uncertainty of one point's distance to its surface, with what neighbours share (a number
    from 0.001 to 1)
    """


@dataclass(kw_only=True, slots=True)
class MapSubmapOptions(OptionGroup):
    """The group ``submap``."""

    cell_m: float = 0.1
    """finest cell of the surfaces that scans are aligned to (a number from 0.01 to 1)"""
    search_cell_m: float = 0.1
    """cell of the grid that loop closing searches (a number from 0.02 to 1)"""
    free_cell_m: float = 0.2
    """cell of the record of free space (a number from 0.02 to 1)"""
    no_return_carve_m: float = 5.0
    """a beam without return frees space up to this far (a number from 0 to 100)"""


@dataclass(kw_only=True, slots=True)
class MapLoopOptions(OptionGroup):
    """The group ``loop``."""

    min_score: float = 0.3
    """a closure's share of points on surfaces less share in free space, by the search (a number
    from 0 to 1)
    """
    min_overlap: float = 0.3
    """share of a submap that the other one must have observed (a number from 0 to 1)"""
    min_agreement: float = 0.75
    """share of the overlap that must lie on surfaces facing the same way (a number from 0 to 1)
    """
    max_ambiguity: float = 0.85
    """a second pose elsewhere may reach this share of the best score (a number from 0 to 1)"""
    drift_per_m: float = 0.03
    """position uncertainty gained per metre of travel since the places were connected (a number
    from 0 to 1)
    """
    drift_rad_per_m: float = 0.006
    """heading uncertainty gained per metre of travel (a number from 0 to 1)"""
    max_half_xy_m: float = 10.0
    """half side of the largest search window (a number from 0.1 to 100)"""
    candidates_max: int = 5
    """older submaps that a new one is compared with (a whole number from 1 to 1000)"""
    places_max: int = 3
    """where the drift may exceed max_half_xy_m: older submaps tried because they look alike; 0:
    none (a whole number from 0 to 1000)
    """


@dataclass(kw_only=True, slots=True)
class MapAdjustmentOptions(OptionGroup):
    """The group ``adjustment``."""

    enabled: bool = True
    """after the graph, move all key scans jointly onto the surfaces that they share"""
    patch_m: float = 0.2
    """surfaces within a cell of this size are taken for one straight line (a number from 0.02 to
    2)
    """
    rounds: int = 6
    """of looking anew which key scans see the same surface (a whole number from 1 to 50)"""
    points_max: int = 120
    """points of a key scan that are used (a whole number from 10 to 10000)"""


@dataclass(kw_only=True, slots=True)
class MapMapOptions(OptionGroup):
    """The group ``map``."""

    resolution_m: float = 0.05
    """side of a map cell (a number from 0.005 to 1)"""
    hit_probability: float = 0.7
    """belief that a cell is occupied where a beam ended (a number from 0.5 to 0.999)"""
    miss_probability: float = 0.4
    """belief that a cell is occupied where a beam passed through (a number from 0.001 to 0.5)"""
    clamp_probability: float = 0.97
    """belief stays within [1 - p, p], so that a map can change its mind (a number from 0.5 to
    0.9999)
    """
    no_return_carve_m: float = 5.0
    """a beam without return frees cells up to this far (a number from 0 to 200)"""
    max_range_m: float = 80.0
    """returns beyond count as beams without return (a number from 0.1 to 1000)"""


@dataclass(kw_only=True, slots=True)
class MapTextureOptions(OptionGroup):
    """The group ``texture``."""

    resolution_m: float = 0.01
    """side of a cell of the texture (a number from 0.001 to 0.5)"""
    max_blur_m: float = 0.015
    """floor that a pixel and the motion smear over more is not used (a number from 0.001 to 1)"""
    height_tolerance_m: float = 0.01
    """what is nearer to the floor's plane is floor, beyond the camera's noise (a number from
    0.001 to 0.5)
    """
    min_travel_m: float = 0.02
    """a frame is used after so much travel (a number from 0 to 10)"""
    min_turn_rad: float = 0.01
    """or after so much turning (a number from 0 to 3.2)"""
    exposure_s: float = 0.01
    """how long the shutter is open: motion smears so long (a number from 0 to 0.2)"""
    fill_gap_m: float = 0.03
    """unseen cells between seen ones this near are filled from them (a number from 0 to 1)"""
    cloud_cube_m: float = 0.0
    """side of the cubes in which all points seen are gathered in colour; 0: none are (a number
    from 0 to 1)
    """
    correct_mount: bool = True
    """estimate roll, pitch and height of the camera from the floor"""
    correct_clock: bool = True
    """estimate how late the camera's stamps are from its motion over the floor"""
    level_exposure: bool = True
    """level the brightness of the frames"""
    refine_poses: bool = True
    """move each frame by the few millimetres that make it agree with the floor seen before"""


@dataclass(kw_only=True, slots=True)
class MapOptions(CallOptions):
    """Of ``loopstone.map`` and ``loopstone.Mapper``: ``loopstone config``."""

    _of: ClassVar[str] = "map"

    loop_closure: bool = True
    """recognise places seen before and correct the map"""
    calibration: bool = True
    """find out by the drive how the laser sits on the robot, and put right what is told wrong"""
    front_end: MapFrontEndOptions = _field(default_factory=MapFrontEndOptions)
    match: MapMatchOptions = _field(default_factory=MapMatchOptions)
    submap: MapSubmapOptions = _field(default_factory=MapSubmapOptions)
    loop: MapLoopOptions = _field(default_factory=MapLoopOptions)
    adjustment: MapAdjustmentOptions = _field(default_factory=MapAdjustmentOptions)
    map: MapMapOptions = _field(default_factory=MapMapOptions)
    texture: MapTextureOptions = _field(default_factory=MapTextureOptions)


@dataclass(kw_only=True, slots=True)
class LandmarkMapLandmarksReflectorsOptions(OptionGroup):
    """The group ``reflectors``."""

    brightness: float = 3.0
    """a beam is bright from so many times the median intensity of beams of about its range on (a
    number from 1 to 1000)
    """
    intensity_min: float = 0.0
    """and from this intensity on, in the scanner's own unit; 0: any (a number from 0 to
    1000000000)
    """
    beams_min: int = 2
    """bright beams that make a reflector (a whole number from 1 to 1000)"""
    width_max_m: float = 0.5
    """wider things are no reflectors (a number from 0.01 to 10)"""
    range_max_m: float = 30.0
    """farther ones are left out (a number from 0.5 to 500)"""
    range_sigma_m: float = 0.01
    """standard deviation of a reflector's range (a number from 0.0001 to 10)"""
    bearing_sigma_rad: float = 0.001
    """and of its bearing, beside that of a beam's width (a number from 1e-05 to 1)"""
    stamp_sigma_s: float = 0.01
    """and of the time at which it was seen: a robot that moves sees it elsewhere (a number from
    0 to 1)
    """


@dataclass(kw_only=True, slots=True)
class LandmarkMapLandmarksSightingsOptions(OptionGroup):
    """The group ``sightings``."""

    range_sigma_m: float = 0.15
    """standard deviation of a range (a number from 0.0001 to 100)"""
    bearing_sigma_rad: float = 0.04
    """and of a bearing (a number from 1e-05 to 1)"""


@dataclass(kw_only=True, slots=True)
class LandmarkMapLandmarksOptions(OptionGroup):
    """The group ``landmarks``."""

    sightings_min: int = 4
    """a thing seen less often is no landmark (a whole number from 2 to 1000)"""
    baseline_min_m: float = 0.5
    """nor is one seen from places no farther apart: a mirror image passes for a thing there (a
    number from 0 to 100)
    """
    clutter_share: float = 0.05
    """of what is seen that is no landmark (a number from 0.0001 to 0.9)"""
    robust_width: float = 3.0
    """standard deviations up to which a sighting counts nearly in full (a number from 0.1 to
    1000)
    """
    radius_max_m: float = 0.5
    """of the roundest landmark; 0: all are taken to be flat (a number from 0 to 2)"""
    reflectors: LandmarkMapLandmarksReflectorsOptions = _field(
        default_factory=LandmarkMapLandmarksReflectorsOptions
    )
    sightings: LandmarkMapLandmarksSightingsOptions = _field(
        default_factory=LandmarkMapLandmarksSightingsOptions
    )


@dataclass(kw_only=True, slots=True)
class LandmarkMapOptions(MapOptions):
    """Of ``loopstone.map`` with landmarks."""

    _of: ClassVar[str] = "landmark_map"

    landmarks: LandmarkMapLandmarksOptions = _field(default_factory=LandmarkMapLandmarksOptions)


@dataclass(kw_only=True, slots=True)
class LocalizationOdometryNoiseOptions(OptionGroup):
    """The group ``odometry_noise``."""

    turn_from_turn: float = 0.1
    """standard deviation of a turn by its size, alpha1 [rad/rad] (a number from 0 to 10)"""
    turn_from_travel: float = 0.05
    """and by the travel, alpha2 [rad/m] (a number from 0 to 10)"""
    travel_from_travel: float = 0.05
    """standard deviation of the travel by its length, alpha3 [m/m] (a number from 0 to 10)"""
    travel_from_turn: float = 0.02
    """and by the turns, alpha4 [m/rad] (a number from 0 to 10)"""


@dataclass(kw_only=True, slots=True)
class LocalizationVelocityNoiseOptions(OptionGroup):
    """The group ``velocity_noise``."""

    speed_from_speed: float = 0.05
    """standard deviation of the speed by its size, alpha1 [1] (a number from 0 to 10)"""
    speed_from_rate: float = 0.02
    """and by the yaw rate, alpha2 [m/rad] (a number from 0 to 10)"""
    rate_from_speed: float = 0.05
    """standard deviation of the yaw rate by the speed, alpha3 [rad/m] (a number from 0 to 10)"""
    rate_from_rate: float = 0.1
    """and by its size, alpha4 [1] (a number from 0 to 10)"""
    turn_from_speed: float = 0.02
    """standard deviation of the extra turn at the end by the speed, alpha5 [rad/m] (a number
    from 0 to 10)
    """
    turn_from_rate: float = 0.02
    """and by the yaw rate, alpha6 [1] (a number from 0 to 10)"""


@dataclass(kw_only=True, slots=True)
class LocalizationOptions(CallOptions):
    """Of ``loopstone.localize`` and ``loopstone.Localizer``."""

    _of: ClassVar[str] = "localize"

    particles_max: int = 2000
    """particles of all hypotheses together (a whole number from 10 to 1000000)"""
    particles_min: int = 100
    """particles of each hypothesis (a whole number from 10 to 100000)"""
    motion: Literal["auto", "odometry", "velocity"] = "auto"
    """auto: odometry's own covariance, gyro-aided; or the models of Thrun, tables 5.6 and 5.3"""
    sensor: Literal["likelihood_field", "beam_skipping", "beam"] = "likelihood_field"
    """how a scan weighs a particle"""
    resampling: Literal["systematic", "stratified", "residual", "multinomial"] = "systematic"
    """how particles are drawn anew"""
    beams: int = 90
    """beams of a scan that weigh particles (a whole number from 10 to 2000)"""
    update_distance_m: float = 0.1
    """particles are weighed after so much travel (a number from 0 to 5)"""
    update_angle_rad: float = 0.1
    """or after so much turning (a number from 0 to 3.2)"""
    tracking_probability: float = 0.9
    """from here up the state is TRACKING (a number from 0.5 to 1)"""
    lost_probability: float = 0.1
    """below it for the place alone, however precise the pose is in it, the state is LOST (a
    number from 0 to 0.5)
    """
    recover: bool = True
    """search the map when the pose is doubted"""
    snapshot_distance_m: float = 0.0
    """keep the belief for pictures after so much travel; 0: at twelve moments of the run (a
    number from 0 to 1000)
    """
    odometry_noise: LocalizationOdometryNoiseOptions = _field(
        default_factory=LocalizationOdometryNoiseOptions
    )
    velocity_noise: LocalizationVelocityNoiseOptions = _field(
        default_factory=LocalizationVelocityNoiseOptions
    )


@dataclass(kw_only=True, slots=True)
class LandmarkTrackingReflectorsOptions(OptionGroup):
    """The group ``reflectors``."""

    brightness: float = 3.0
    """a beam is bright from so many times the median intensity of beams of about its range on (a
    number from 1 to 1000)
    """
    intensity_min: float = 0.0
    """and from this intensity on, in the scanner's own unit; 0: any (a number from 0 to
    1000000000)
    """
    beams_min: int = 2
    """bright beams that make a reflector (a whole number from 1 to 1000)"""
    width_max_m: float = 0.5
    """wider things are no reflectors (a number from 0.01 to 10)"""
    range_max_m: float = 30.0
    """farther ones are left out (a number from 0.5 to 500)"""
    range_sigma_m: float = 0.01
    """standard deviation of a reflector's range (a number from 0.0001 to 10)"""
    bearing_sigma_rad: float = 0.001
    """and of its bearing, beside that of a beam's width (a number from 1e-05 to 1)"""
    stamp_sigma_s: float = 0.01
    """and of the time at which it was seen: a robot that moves sees it elsewhere (a number from
    0 to 1)
    """


@dataclass(kw_only=True, slots=True)
class LandmarkTrackingSightingsOptions(OptionGroup):
    """The group ``sightings``."""

    range_sigma_m: float = 0.15
    """standard deviation of a range (a number from 0.0001 to 100)"""
    bearing_sigma_rad: float = 0.04
    """and of a bearing (a number from 1e-05 to 1)"""


@dataclass(kw_only=True, slots=True)
class LandmarkTrackingOptions(CallOptions):
    """Of ``loopstone.localize`` among landmarks."""

    _of: ClassVar[str] = "landmarks"

    max_range_m: float = 30.0
    """no landmark is seen farther away (a number from 0.5 to 500)"""
    clutter_share: float = 0.05
    """of what is seen that is of no landmark of the map (a number from 0.0001 to 0.9)"""
    tracking_probability: float = 0.9
    """from here up the state is TRACKING (a number from 0.5 to 1)"""
    lost_probability: float = 0.1
    """below it for the place alone, however precise the pose is in it, the state is LOST (a
    number from 0 to 0.5)
    """
    recover: bool = True
    """search the map when the place is doubted"""
    snapshot_distance_m: float = 0.0
    """keep the belief for pictures after so much travel; 0: at twelve moments of the run (a
    number from 0 to 1000)
    """
    reflectors: LandmarkTrackingReflectorsOptions = _field(
        default_factory=LandmarkTrackingReflectorsOptions
    )
    sightings: LandmarkTrackingSightingsOptions = _field(
        default_factory=LandmarkTrackingSightingsOptions
    )


@dataclass(kw_only=True, slots=True)
class MatchIcpOptions(OptionGroup):
    """The group ``icp``."""

    metric: Literal["point", "line", "plane", "gicp"] = "plane"
    """distance to the nearest point, to the segment between nearest points (in the plane), to
    the line or plane fitted around it, or between planes of both clouds
    """
    max_pair_distance_m: float = 3.0
    """pairs farther apart are ignored, at the start (a number from 1e-06 to 1000000)"""
    final_pair_distance_m: float = 0.2
    """the same in the end; 0: as at the start (a number from 0 to 1000000)"""
    shrink_iterations: int = 20
    """steps from the first pair distance to the last, fewer when they get short; the kernel's
    width shrinks alike (a whole number from 1 to 1000)
    """
    trim_fraction: float = 0.9
    """share of the pairs, closest first, that is used (a number from 0.05 to 1)"""
    kernel: Literal["none", "huber", "cauchy", "geman_mcclure", "tukey", "dcs"] = "cauchy"
    """how distances beyond its width count less"""
    kernel_width_m: float = 0.1
    """distances beyond this count less and less; 0: all alike (a number from 0 to 1000000)"""
    max_iterations: int = 50
    """stop after so many steps (a whole number from 1 to 1000)"""
    tolerance_m: float = 0.0001
    """a shorter step ends the search (a number from 1e-12 to 1)"""
    tolerance_rad: float = 0.0001
    """a smaller turn ends the search (a number from 1e-12 to 1)"""
    tolerance_cost: float = 0.002
    """five steps that lower the residuals by a smaller share end the search (a number from 0 to
    1)
    """
    point_sigma_m: float = 0.02
    """standard deviation of a point; within three of it a point is explained (a number from
    1e-09 to 1000)
    """
    least_explained: float = 0.5
    """share of the points near the target that must be explained, else not_converged (a number
    from 0 to 1)
    """


@dataclass(kw_only=True, slots=True)
class MatchIcpCloudPatchesOptions(OptionGroup):
    """The group ``patches``."""

    neighbours: int = 7
    """so many nearest points, itself included, tell the surface around a point (a whole number
    from 3 to 64)
    """
    dense_radius_m: float = 0.1
    """and all others up to here, so that noise is averaged where points are dense (a number from
    0 to 10)
    """
    reach_m: float = 0.6
    """neighbours farther away are left out (a number from 1e-06 to 1000000)"""
    thickness_share: float = 0.35
    """a neighbourhood thicker than this share of its width is no surface (a number from 0.01 to
    1)
    """
    smooth: bool = True
    """the surface passes through the mean of the neighbours, which averages noise but cuts
    corners; else through the point
    """


@dataclass(kw_only=True, slots=True)
class MatchIcpCloudOptions(OptionGroup):
    """The group ``icp_cloud``."""

    search: Literal["kd_tree", "grid", "projection"] = "kd_tree"
    """how nearest points are looked up; projection: by bearing, for single scans in the plane"""
    cell_size_m: float = 0.1
    """cells of the search by grid (a number from 1e-06 to 1000000)"""
    patches: MatchIcpCloudPatchesOptions = _field(default_factory=MatchIcpCloudPatchesOptions)


@dataclass(kw_only=True, slots=True)
class MatchCloudSearchOptions(OptionGroup):
    """The group ``cloud_search``."""

    turns: Literal["any", "about_z"] = "any"
    """turns to try, in space: all, or those about the z axis of clouds that both stand upright"""
    starts: int = 256
    """about so many turns are tried, evenly spread (a whole number from 1 to 1000000)"""
    points: int = 80
    """source points that all starts are tried with; the best are tried with more (a whole number
    from 10 to 100000)
    """
    overlap: float = 1.0
    """share of the source that the model holds; the farthest points are left out (a number from
    0.05 to 1)
    """
    rival_ratio: float = 1.1
    """another pose with less than so many times the best rmse makes the answer ambiguous (a
    number from 1 to 100)
    """
    least_explained: float = 0.5
    """share of the source that must lie within a fourteenth of the model's radius from it, else
    not_converged (a number from 0 to 1)
    """
    max_iterations: int = 100
    """steps of the last refinement (a whole number from 1 to 10000)"""


@dataclass(kw_only=True, slots=True)
class MatchScansOptions(OptionGroup):
    """The group ``scans``."""

    search_half_xy_m: float = 1.0
    """how far the guess may be off in x and y; with search_half_yaw_rad 0: no search (a number
    from 0 to 3)
    """
    search_half_yaw_rad: float = 0.87
    """how far the guess's heading may be off (a number from 0 to 3.15)"""
    candidates: int = 10
    """poses of the search that are looked into (a whole number from 1 to 50)"""
    max_iterations: int = 30
    """Gauss-Newton steps (a whole number from 1 to 200)"""
    kernel_width_m: float = 0.03
    """distances beyond this count less and less (Cauchy kernel) (a number from 0.001 to 1)"""


@dataclass(kw_only=True, slots=True)
class MatchMapFieldOptions(OptionGroup):
    """The group ``field``."""

    reach_m: float = 0.3
    """distances to walls grow up to here, on the finest level (a number from 0.01 to 10)"""
    levels: int = 3
    """each with cells and reach twice the size (a whole number from 1 to 8)"""
    occupied_percent: int = 65
    """cells of this occupancy or more are walls (a whole number from 1 to 100)"""


@dataclass(kw_only=True, slots=True)
class MatchMapOptions(OptionGroup):
    """The group ``map``."""

    cell_m: float = 0.1
    """cell of the search; a whole multiple of the map's is best (a number from 0.02 to 1)"""
    tolerance_m: float = 0.1
    """a point so near to a wall counts in full, out to 2.5 times that less and less (a number
    from 0.01 to 1)
    """
    robot_radius_m: float = 0.0
    """places nearer to a wall are left out (a number from 0 to 10)"""
    field: MatchMapFieldOptions = _field(default_factory=MatchMapFieldOptions)


@dataclass(kw_only=True, slots=True)
class MatchMapMatchOptions(OptionGroup):
    """The group ``map_match``."""

    min_score: float = 0.4
    """poses that score less are left out (a number from -1 to 1)"""
    sure_score: float = 0.6
    """a best pose that explains less of the scan is never called sure (a number from 0 to 1)"""
    sure_gap: float = 0.03
    """nor is one that explains no more than so much above the next best (a number from 0 to 1)"""
    poses_max: int = 5
    """distinct poses to return (a whole number from 1 to 1000)"""
    refined_max: int = 64
    """distinct poses of the lattice to refine, the best first (a whole number from 1 to 10000)"""
    points_max: int = 160
    """points of the scan to search with; the refinement takes up to 400 (a whole number from 10
    to 2000)
    """
    range_max_m: float = 15.0
    """farther points only when there are few others: they make headings many (a number from 1 to
    1000)
    """
    distinct_m: float = 1.0
    """poses nearer to each other than this and distinct_rad are one (a number from 0.01 to 100)
    """
    distinct_rad: float = 0.35
    """poses nearer to each other than this and distinct_m are one (a number from 0.001 to 3.2)"""


@dataclass(kw_only=True, slots=True)
class MatchFieldOptions(OptionGroup):
    """The group ``field``."""

    max_iterations: int = 20
    """Gauss-Newton steps on each level (a whole number from 1 to 200)"""
    kernel_width_m: float = 0.05
    """distances beyond this count less and less (Cauchy kernel); on coarser levels in proportion
    to the cell (a number from 0.001 to 1)
    """
    point_sigma_m: float = 0.01
    """standard deviation of a point; the least that the covariance is computed with (a number
    from 1e-06 to 1)
    """


@dataclass(kw_only=True, slots=True)
class MatchGridOptions(OptionGroup):
    """The group ``grid``."""

    max_iterations: int = 15
    """Gauss-Newton steps on each level (a whole number from 1 to 200)"""
    kernel_width_m: float = 0.04
    """distances beyond this count less and less (Cauchy kernel); on coarser levels in proportion
    to the cell (a number from 0.001 to 1)
    """
    residual_sigma_m: float = 0.04
    """uncertainty of one point's distance to its surface, with what neighbours share (a number
    from 0.001 to 1)
    """


@dataclass(kw_only=True, slots=True)
class MatchOptions(CallOptions):
    """Of ``loopstone.match`` in the plane."""

    _of: ClassVar[str] = "match"

    icp: MatchIcpOptions = _field(default_factory=MatchIcpOptions)
    icp_cloud: MatchIcpCloudOptions = _field(default_factory=MatchIcpCloudOptions)
    cloud_search: MatchCloudSearchOptions = _field(default_factory=MatchCloudSearchOptions)
    scans: MatchScansOptions = _field(default_factory=MatchScansOptions)
    map: MatchMapOptions = _field(default_factory=MatchMapOptions)
    map_match: MatchMapMatchOptions = _field(default_factory=MatchMapMatchOptions)
    field: MatchFieldOptions = _field(default_factory=MatchFieldOptions)
    grid: MatchGridOptions = _field(default_factory=MatchGridOptions)


@dataclass(kw_only=True, slots=True)
class Match3dIcpOptions(OptionGroup):
    """The group ``icp``."""

    metric: Literal["point", "line", "plane", "gicp"] = "plane"
    """distance to the nearest point, to the segment between nearest points (in the plane), to
    the line or plane fitted around it, or between planes of both clouds
    """
    max_pair_distance_m: float = 3.0
    """pairs farther apart are ignored, at the start (a number from 1e-06 to 1000000)"""
    final_pair_distance_m: float = 0.2
    """the same in the end; 0: as at the start (a number from 0 to 1000000)"""
    shrink_iterations: int = 20
    """steps from the first pair distance to the last, fewer when they get short; the kernel's
    width shrinks alike (a whole number from 1 to 1000)
    """
    trim_fraction: float = 0.9
    """share of the pairs, closest first, that is used (a number from 0.05 to 1)"""
    kernel: Literal["none", "huber", "cauchy", "geman_mcclure", "tukey", "dcs"] = "cauchy"
    """how distances beyond its width count less"""
    kernel_width_m: float = 0.1
    """distances beyond this count less and less; 0: all alike (a number from 0 to 1000000)"""
    max_iterations: int = 50
    """stop after so many steps (a whole number from 1 to 1000)"""
    tolerance_m: float = 0.0001
    """a shorter step ends the search (a number from 1e-12 to 1)"""
    tolerance_rad: float = 0.0001
    """a smaller turn ends the search (a number from 1e-12 to 1)"""
    tolerance_cost: float = 0.002
    """five steps that lower the residuals by a smaller share end the search (a number from 0 to
    1)
    """
    point_sigma_m: float = 0.02
    """standard deviation of a point; within three of it a point is explained (a number from
    1e-09 to 1000)
    """
    least_explained: float = 0.5
    """share of the points near the target that must be explained, else not_converged (a number
    from 0 to 1)
    """


@dataclass(kw_only=True, slots=True)
class Match3dIcpCloudPatchesOptions(OptionGroup):
    """The group ``patches``."""

    neighbours: int = 12
    """so many nearest points, itself included, tell the surface around a point (a whole number
    from 3 to 64)
    """
    dense_radius_m: float = 0.0
    """and all others up to here, so that noise is averaged where points are dense (a number from
    0 to 10)
    """
    reach_m: float = 0.6
    """neighbours farther away are left out (a number from 1e-06 to 1000000)"""
    thickness_share: float = 0.35
    """a neighbourhood thicker than this share of its width is no surface (a number from 0.01 to
    1)
    """
    smooth: bool = False
    """the surface passes through the mean of the neighbours, which averages noise but cuts
    corners; else through the point
    """


@dataclass(kw_only=True, slots=True)
class Match3dIcpCloudOptions(OptionGroup):
    """The group ``icp_cloud``."""

    search: Literal["kd_tree", "grid", "projection"] = "kd_tree"
    """how nearest points are looked up; projection: by bearing, for single scans in the plane"""
    cell_size_m: float = 0.1
    """cells of the search by grid (a number from 1e-06 to 1000000)"""
    patches: Match3dIcpCloudPatchesOptions = _field(default_factory=Match3dIcpCloudPatchesOptions)


@dataclass(kw_only=True, slots=True)
class Match3dCloudSearchOptions(OptionGroup):
    """The group ``cloud_search``."""

    turns: Literal["any", "about_z"] = "any"
    """turns to try, in space: all, or those about the z axis of clouds that both stand upright"""
    starts: int = 256
    """about so many turns are tried, evenly spread (a whole number from 1 to 1000000)"""
    points: int = 80
    """source points that all starts are tried with; the best are tried with more (a whole number
    from 10 to 100000)
    """
    overlap: float = 1.0
    """share of the source that the model holds; the farthest points are left out (a number from
    0.05 to 1)
    """
    rival_ratio: float = 1.1
    """another pose with less than so many times the best rmse makes the answer ambiguous (a
    number from 1 to 100)
    """
    least_explained: float = 0.5
    """share of the source that must lie within a fourteenth of the model's radius from it, else
    not_converged (a number from 0 to 1)
    """
    max_iterations: int = 100
    """steps of the last refinement (a whole number from 1 to 10000)"""


@dataclass(kw_only=True, slots=True)
class Match3dScansOptions(OptionGroup):
    """The group ``scans``."""

    search_half_xy_m: float = 1.0
    """how far the guess may be off in x and y; with search_half_yaw_rad 0: no search (a number
    from 0 to 3)
    """
    search_half_yaw_rad: float = 0.87
    """how far the guess's heading may be off (a number from 0 to 3.15)"""
    candidates: int = 10
    """poses of the search that are looked into (a whole number from 1 to 50)"""
    max_iterations: int = 30
    """Gauss-Newton steps (a whole number from 1 to 200)"""
    kernel_width_m: float = 0.03
    """distances beyond this count less and less (Cauchy kernel) (a number from 0.001 to 1)"""


@dataclass(kw_only=True, slots=True)
class Match3dMapFieldOptions(OptionGroup):
    """The group ``field``."""

    reach_m: float = 0.3
    """distances to walls grow up to here, on the finest level (a number from 0.01 to 10)"""
    levels: int = 3
    """each with cells and reach twice the size (a whole number from 1 to 8)"""
    occupied_percent: int = 65
    """cells of this occupancy or more are walls (a whole number from 1 to 100)"""


@dataclass(kw_only=True, slots=True)
class Match3dMapOptions(OptionGroup):
    """The group ``map``."""

    cell_m: float = 0.1
    """cell of the search; a whole multiple of the map's is best (a number from 0.02 to 1)"""
    tolerance_m: float = 0.1
    """a point so near to a wall counts in full, out to 2.5 times that less and less (a number
    from 0.01 to 1)
    """
    robot_radius_m: float = 0.0
    """places nearer to a wall are left out (a number from 0 to 10)"""
    field: Match3dMapFieldOptions = _field(default_factory=Match3dMapFieldOptions)


@dataclass(kw_only=True, slots=True)
class Match3dMapMatchOptions(OptionGroup):
    """The group ``map_match``."""

    min_score: float = 0.4
    """poses that score less are left out (a number from -1 to 1)"""
    sure_score: float = 0.6
    """a best pose that explains less of the scan is never called sure (a number from 0 to 1)"""
    sure_gap: float = 0.03
    """nor is one that explains no more than so much above the next best (a number from 0 to 1)"""
    poses_max: int = 5
    """distinct poses to return (a whole number from 1 to 1000)"""
    refined_max: int = 64
    """distinct poses of the lattice to refine, the best first (a whole number from 1 to 10000)"""
    points_max: int = 160
    """points of the scan to search with; the refinement takes up to 400 (a whole number from 10
    to 2000)
    """
    range_max_m: float = 15.0
    """farther points only when there are few others: they make headings many (a number from 1 to
    1000)
    """
    distinct_m: float = 1.0
    """poses nearer to each other than this and distinct_rad are one (a number from 0.01 to 100)
    """
    distinct_rad: float = 0.35
    """poses nearer to each other than this and distinct_m are one (a number from 0.001 to 3.2)"""


@dataclass(kw_only=True, slots=True)
class Match3dFieldOptions(OptionGroup):
    """The group ``field``."""

    max_iterations: int = 20
    """Gauss-Newton steps on each level (a whole number from 1 to 200)"""
    kernel_width_m: float = 0.05
    """distances beyond this count less and less (Cauchy kernel); on coarser levels in proportion
    to the cell (a number from 0.001 to 1)
    """
    point_sigma_m: float = 0.01
    """standard deviation of a point; the least that the covariance is computed with (a number
    from 1e-06 to 1)
    """


@dataclass(kw_only=True, slots=True)
class Match3dGridOptions(OptionGroup):
    """The group ``grid``."""

    max_iterations: int = 15
    """Gauss-Newton steps on each level (a whole number from 1 to 200)"""
    kernel_width_m: float = 0.04
    """distances beyond this count less and less (Cauchy kernel); on coarser levels in proportion
    to the cell (a number from 0.001 to 1)
    """
    residual_sigma_m: float = 0.04
    """uncertainty of one point's distance to its surface, with what neighbours share (a number
    from 0.001 to 1)
    """


@dataclass(kw_only=True, slots=True)
class Match3dOptions(CallOptions):
    """Of ``loopstone.match`` in space."""

    _of: ClassVar[str] = "match_3d"

    icp: Match3dIcpOptions = _field(default_factory=Match3dIcpOptions)
    icp_cloud: Match3dIcpCloudOptions = _field(default_factory=Match3dIcpCloudOptions)
    cloud_search: Match3dCloudSearchOptions = _field(default_factory=Match3dCloudSearchOptions)
    scans: Match3dScansOptions = _field(default_factory=Match3dScansOptions)
    map: Match3dMapOptions = _field(default_factory=Match3dMapOptions)
    map_match: Match3dMapMatchOptions = _field(default_factory=Match3dMapMatchOptions)
    field: Match3dFieldOptions = _field(default_factory=Match3dFieldOptions)
    grid: Match3dGridOptions = _field(default_factory=Match3dGridOptions)


@dataclass(kw_only=True, slots=True)
class OptimizeSolverOptions(OptionGroup):
    """The group ``solver``."""

    method: Literal["gauss_newton", "levenberg_marquardt", "dogleg"] = "gauss_newton"
    """how steps are found"""
    max_iterations: int = 100
    """stop after so many steps (a whole number from 1 to 10000)"""
    relative_tolerance: float = 1e-07
    """stop when less than this share of the cost is left to gain (a number from 0 to 0.1)"""
    robust_kernel: Literal["none", "huber", "cauchy", "geman_mcclure", "tukey", "dcs"] = "none"
    """how edges that disagree with the rest are softened"""
    robust_width: float = 1.0
    """standard deviations up to which an edge counts in full (a number from 0.001 to 1000000)"""
    robust_everywhere: bool = False
    """soften every edge, not just the loop closures"""


@dataclass(kw_only=True, slots=True)
class OptimizeGncOptions(OptionGroup):
    """The group ``gnc``."""

    inlier_chi2: float = 25.902
    """squared standard deviations that a true loop closure may be off; 25.902: 0.99999 of a chi-
    square with 3 degrees of freedom (a number from 0.1 to 1000000)
    """
    sharpening: float = 1.4
    """by how much outliers are told apart more sharply from round to round (a number from 1.01
    to 10)
    """
    max_rounds: int = 200
    """stop after so many rounds (a whole number from 1 to 10000)"""
    start_from_odometry: bool = True
    """start from the chain of odometry edges, not from the graph's poses"""
    consistency_first: bool = False
    """begin with the loop closures that agree with one another"""


@dataclass(kw_only=True, slots=True)
class OptimizeCertificateOptions(OptionGroup):
    """The group ``certificate``."""

    relative_gap: float = 1e-07
    """certified means that no solution is cheaper by more than this share of the cost (a number
    from 1e-12 to 1)
    """
    max_iterations: int = 100
    """steps of one descent to a minimum (a whole number from 1 to 10000)"""
    max_rank: int = 4
    """of the relaxation that leads out of a local minimum, in complex numbers; 1: no way out (a
    whole number from 1 to 10)
    """


@dataclass(kw_only=True, slots=True)
class OptimizeOptions(CallOptions):
    """Of ``loopstone.optimize``."""

    _of: ClassVar[str] = "optimize"

    solver: OptimizeSolverOptions = _field(default_factory=OptimizeSolverOptions)
    gnc: OptimizeGncOptions = _field(default_factory=OptimizeGncOptions)
    certificate: OptimizeCertificateOptions = _field(default_factory=OptimizeCertificateOptions)


@dataclass(kw_only=True, slots=True)
class SimulationDriveOptions(OptionGroup):
    """The group ``drive``."""

    speed_m_s: float = 0.7
    """top speed (a number from 0.1 to 2)"""
    yaw_rate_rad_s: float = 1.0
    """fastest turn (a number from 0.2 to 3)"""
    acceleration_m_s2: float = 0.6
    """how fast it gains speed (a number from 0.1 to 5)"""
    standstill_s: float = 3.0
    """rest before it sets off (a number from 0 to 60)"""
    laps: int = 1
    """times that it goes the whole route, each time back to the start (a whole number from 1 to
    1000)
    """


@dataclass(kw_only=True, slots=True)
class SimulationLaserOptions(OptionGroup):
    """The group ``laser``."""

    rate_hz: float = 10.0
    """scans a second (a number from 0.1 to 100)"""
    beams: int = 1081
    """beams of a scan (a whole number from 2 to 20000)"""
    fov_rad: float = 4.71238898038469
    """from the first beam to the last, centred on the lidar's x axis (a number from 0.01 to
    6.2832)
    """
    range_min_m: float = 0.1
    """nearer returns are bad beams (a number from 0 to 5)"""
    range_max_m: float = 30.0
    """farther surfaces give no return (a number from 0.5 to 500)"""
    noise_m: float = 0.01
    """standard deviation of a range (a number from 0 to 1)"""
    dropout_probability: float = 0.002
    """share of bad beams (a number from 0 to 1)"""
    sweep_s: float = 0.01875
    """time from the first beam to the last (a number from 0 to 1)"""
    clock_offset_s: float = 0.005
    """the laser's stamps are this late (a number from -1 to 1)"""


@dataclass(kw_only=True, slots=True)
class SimulationWheelsOptions(OptionGroup):
    """The group ``wheels``."""

    rate_hz: float = 40.0
    """readings a second (a number from 1 to 1000)"""
    scale_error: float = 0.02
    """both sides too large or too small, share of the distance (a number from 0 to 0.5)"""
    imbalance: float = 0.0003
    """one side against the other, share of the distance (a number from 0 to 0.2)"""
    turn_slip: float = 0.01
    """wheels turn more than the robot, share (a number from 0 to 0.5)"""
    slip_m_per_sqrt_m: float = 0.003
    """random slip: standard deviation after 1 m of travel; grows with the root (a number from 0
    to 0.5)
    """


@dataclass(kw_only=True, slots=True)
class SimulationImuOptions(OptionGroup):
    """The group ``imu``."""

    rate_hz: float = 100.0
    """samples a second (a number from 1 to 2000)"""
    bias_rad_s: float = 0.01
    """bias of the gyro, drawn as the systematic errors of the wheels (a number from 0 to 1)"""
    bias_drift_rad_s: float = 0.0002
    """random walk of the bias: standard deviation after a minute (a number from 0 to 0.1)"""
    noise_rad_s: float = 0.004
    """standard deviation of a gyro sample (a number from 0 to 1)"""
    acceleration_noise_m_s2: float = 0.05
    """standard deviation of an accelerometer sample (a number from 0 to 10)"""


@dataclass(kw_only=True, slots=True)
class SimulationCameraDepthOptions(OptionGroup):
    """The group ``depth``."""

    noise_steps: float = 0.7
    """standard deviation in steps of the Kinect's disparity (a number from 0 to 100)"""
    dropout_probability: float = 0.003
    """share of pixels without depth for no visible reason (a number from 0 to 1)"""
    grazing_dropout: float = 1.0
    """and of those that see a surface edge-on; none from 6 deg on (a number from 0 to 1)"""
    projector_baseline_m: float = 0.075
    """what its light can't reach has no depth; 0: no shadows (a number from 0 to 1)"""


@dataclass(kw_only=True, slots=True)
class SimulationCameraColourOptions(OptionGroup):
    """The group ``colour``."""

    exposure_s: float = 0.006
    """smears the floor along its motion (a number from 0 to 0.1)"""
    gain_wander: float = 0.04
    """automatic exposure: standard deviation of log brightness (a number from 0 to 1)"""
    vignetting: float = 0.06
    """how much darker the corners are, share (a number from 0 to 0.9)"""
    noise_levels: float = 1.5
    """standard deviation of a channel, of 255 (a number from 0 to 100)"""
    lag_s: float = 0.013
    """colour is taken this much after depth, and stamped so (a number from -0.5 to 0.5)"""


@dataclass(kw_only=True, slots=True)
class SimulationCameraOptions(OptionGroup):
    """The group ``camera``."""

    rate_hz: float = 5.0
    """frames a second (a number from 0.1 to 60)"""
    clock_offset_s: float = 0.0
    """the camera's stamps are this late (a number from -1 to 1)"""
    pitch_error_rad: float = 0.0175
    """it looks this much farther down than the robot's file says (a number from -0.5 to 0.5)"""
    roll_error_rad: float = 0.005
    """and leans this much to the right (a number from -0.5 to 0.5)"""
    height_error_m: float = 0.004
    """and sits this much higher (a number from -0.5 to 0.5)"""
    depth: SimulationCameraDepthOptions = _field(default_factory=SimulationCameraDepthOptions)
    colour: SimulationCameraColourOptions = _field(default_factory=SimulationCameraColourOptions)


@dataclass(kw_only=True, slots=True)
class SimulationFaultsOptions(OptionGroup):
    """The group ``faults``."""

    odometry: Literal[
        "none", "missing", "stuck", "scaled", "mirrored", "lagging", "jumping"
    ] = "none"
    """what is wrong with wheels and gyro"""
    strength: float = 0.0
    """factor, seconds or metres of that fault; 0: the usual one, 1.6, 0.4 s or 1 m (a number
    from 0 to 100)
    """
    from_s: float = 0.0
    """when it begins (a number from 0 to 1000000)"""
    to_s: float = 0.0
    """when it ends; 0: never (a number from 0 to 1000000)"""
    scans_dropped: float = 0.0
    """share of scans that are lost (a number from 0 to 1)"""
    glass: float = 0.0
    """share of the walls, in pieces of half a metre, that return nothing (a number from 0 to 1)
    """


@dataclass(kw_only=True, slots=True)
class SimulationRealismRangeOptions(OptionGroup):
    """The group ``range``."""

    on: bool = False
    """whether it happens; --realism sets it"""
    bias_m: float = 0.01
    """all ranges too long or too short: between half and all of it, drawn once (a number from 0
    to 1)
    """
    scale_error: float = 0.003
    """likewise, share of the range (a number from 0 to 0.2)"""
    noise_per_m: float = 0.001
    """standard deviation that grows with the range (a number from 0 to 0.1)"""
    beam_width_rad: float = 0.01
    """spreads ranges on surfaces met at an angle (a number from 0 to 0.1)"""


@dataclass(kw_only=True, slots=True)
class SimulationRealismMixedOptions(OptionGroup):
    """The group ``mixed``."""

    on: bool = False
    """whether it happens; --realism sets it"""
    beam_width_rad: float = 0.01
    """of the beam (a number from 0.0001 to 0.1)"""
    least_step_m: float = 0.15
    """surfaces nearer together than this are told as one (a number from 0 to 10)"""
    blend_m: float = 1.5
    """of surfaces nearer together than this a range between them may come; else one of both (a
    number from 0 to 100)
    """


@dataclass(kw_only=True, slots=True)
class SimulationRealismDropoutsOptions(OptionGroup):
    """The group ``dropouts``."""

    on: bool = False
    """whether it happens; --realism sets it"""
    share: float = 0.003
    """of beams that are lost anywhere (a number from 0 to 1)"""
    dark_share: float = 0.06
    """of surfaces that are dark (a number from 0 to 1)"""
    dark_reach_m: float = 6.0
    """a dark surface this far away returns half of the beams (a number from 0.1 to 100)"""
    grazing_rad: float = 1.3
    """incidence, from the normal, at which beams begin to be lost; all are edge-on (a number
    from 0 to 1.5707)
    """
    seen_as_free: float = 0.5
    """share of lost beams that the log calls beyond range; the others are bad (a number from 0
    to 1)
    """


@dataclass(kw_only=True, slots=True)
class SimulationRealismStepsOptions(OptionGroup):
    """The group ``steps``."""

    on: bool = False
    """whether it happens; --realism sets it"""
    step_m: float = 0.01
    """ranges are whole steps (a number from 0.0001 to 1)"""


@dataclass(kw_only=True, slots=True)
class SimulationRealismSweepOptions(OptionGroup):
    """The group ``sweep``."""

    on: bool = False
    """whether it happens; --realism sets it"""
    sweep_s: float = 0.075
    """true time from the first beam to the last; the log says 0 (a number from 0 to 1)"""


@dataclass(kw_only=True, slots=True)
class SimulationRealismMountOptions(OptionGroup):
    """The group ``mount``."""

    on: bool = False
    """whether it happens; --realism sets it"""
    x_m: float = 0.03
    """ahead or behind of where the file says: between half and all of it, drawn once (a number
    from 0 to 10)
    """
    y_m: float = 0.03
    """likewise, to the side (a number from 0 to 10)"""
    yaw_rad: float = 0.035
    """likewise, turned (a number from 0 to 3.2)"""


@dataclass(kw_only=True, slots=True)
class SimulationRealismBlockedOptions(OptionGroup):
    """The group ``blocked``."""

    on: bool = False
    """whether it happens; --realism sets it"""
    at_s: float = 30.0
    """when it begins (a number from 0 to 1000000)"""
    length_s: float = 15.0
    """how long it lasts (a number from 0 to 1000000)"""
    nearest_m: float = 0.05
    """of its returns (a number from 0 to 5)"""
    farthest_m: float = 0.29
    """of its returns (a number from 0 to 5)"""
    seen_share: float = 0.03
    """share of beams that still pass (a number from 0 to 1)"""


@dataclass(kw_only=True, slots=True)
class SimulationRealismDirtyOptions(OptionGroup):
    """The group ``dirty``."""

    on: bool = False
    """whether it happens; --realism sets it"""
    middle_rad: float = 0.8
    """of the sector, in the scan (a number from -3.1416 to 3.1416)"""
    width_rad: float = 0.6
    """of the sector (a number from 0 to 6.2832)"""
    share: float = 0.7
    """of its beams that are spoilt (a number from 0 to 1)"""


@dataclass(kw_only=True, slots=True)
class SimulationRealismUpsideDownOptions(OptionGroup):
    """The group ``upside_down``."""

    on: bool = False
    """whether it happens; --realism sets it"""


@dataclass(kw_only=True, slots=True)
class SimulationRealismStampsOptions(OptionGroup):
    """The group ``stamps``."""

    on: bool = False
    """whether it happens; --realism sets it"""
    jitter_s: float = 0.004
    """standard deviation of every stamp (a number from 0 to 1)"""
    latency_s: float = 0.03
    """the laser's stamps are so late (a number from 0 to 1)"""
    late_share: float = 0.005
    """of stamps that are later still (a number from 0 to 1)"""
    late_s: float = 0.15
    """by up to so much (a number from 0 to 5)"""
    drift_ppm: float = 100.0
    """the laser's clock runs faster or slower: between half and all of it, drawn once (a number
    from 0 to 10000)
    """


@dataclass(kw_only=True, slots=True)
class SimulationRealismLossOptions(OptionGroup):
    """The group ``loss``."""

    on: bool = False
    """whether it happens; --realism sets it"""
    share: float = 0.01
    """of messages lost one by one (a number from 0 to 1)"""
    every_s: float = 40.0
    """mean time between bursts (a number from 0.1 to 1000000)"""
    longest_s: float = 2.5
    """a burst lasts up to so long (a number from 0 to 1000)"""
    odometry_too: bool = True
    """wheels and gyro are lost with the scans"""


@dataclass(kw_only=True, slots=True)
class SimulationRealismWheelsOptions(OptionGroup):
    """The group ``wheels``."""

    on: bool = False
    """whether it happens; --realism sets it"""
    scale_error: float = 0.02
    """of distances, on top of wheels.scale_error: between half and all of it, drawn once (a
    number from 0 to 0.5)
    """
    imbalance: float = 0.005
    """one side against the other, share of the distance: likewise (a number from 0 to 0.2)"""
    slip_every_m: float = 8.0
    """mean way between slips (a number from 0.1 to 1000000)"""
    slip_m: float = 0.15
    """wheels spin up to so far without moving it (a number from 0 to 10)"""
    slip_rad: float = 0.08
    """and turn up to so far, either way (a number from 0 to 3.2)"""


@dataclass(kw_only=True, slots=True)
class SimulationRealismGyroOptions(OptionGroup):
    """The group ``gyro``."""

    on: bool = False
    """whether it happens; --realism sets it"""
    scale_error: float = 0.02
    """of the yaw rate: between half and all of it, drawn once (a number from 0 to 0.5)"""
    bias_rad_s: float = 0.01
    """on top of imu.bias_rad_s: likewise (a number from 0 to 1)"""


@dataclass(kw_only=True, slots=True)
class SimulationRealismRollingOptions(OptionGroup):
    """The group ``rolling``."""

    on: bool = False
    """whether it happens; --realism sets it"""
    skipped_s: float = 6.0
    """the log begins so long after the robot set off (a number from 0 to 1000000)"""


@dataclass(kw_only=True, slots=True)
class SimulationRealismUnevenOptions(OptionGroup):
    """The group ``uneven``."""

    on: bool = False
    """whether it happens; --realism sets it"""
    slope_rad: float = 0.006
    """root mean square slope of the floor (a number from 0 to 0.5)"""
    sill_m: float = 0.012
    """height of the sills (a number from 0 to 0.2)"""
    sill_every_m: float = 9.0
    """between sills (a number from 1 to 1000000)"""
    ramp_rad: float = 0.06
    """slope of the ramps (a number from 0 to 0.5)"""
    ramp_every_m: float = 120.0
    """from one ramp up to the next (a number from 8 to 1000000)"""
    ceiling_m: float = 2.6
    """height of the ceiling (a number from 0.6 to 100)"""


@dataclass(kw_only=True, slots=True)
class SimulationRealismCarriedOptions(OptionGroup):
    """The group ``carried``."""

    on: bool = False
    """whether it happens; --realism sets it"""
    at_s: float = 60.0
    """when it is lifted (a number from 0 to 1000000)"""
    distance_m: float = 3.0
    """how far it is carried (a number from 0 to 100)"""
    lift_s: float = 4.0
    """how long that takes (a number from 0.1 to 1000)"""
    turn_rad: float = 1.0
    """how far it is turned meanwhile (a number from 0 to 3.1416)"""


@dataclass(kw_only=True, slots=True)
class SimulationRealismCarriedBlindOptions(OptionGroup):
    """The group ``carried_blind``."""

    on: bool = False
    """whether it happens; --realism sets it"""
    at_s: float = 110.0
    """when it is lifted (a number from 0 to 1000000)"""
    distance_m: float = 3.0
    """how far it is carried (a number from 0 to 100)"""
    lift_s: float = 4.0
    """how long that takes (a number from 0.1 to 1000)"""
    turn_rad: float = 1.0
    """how far it is turned meanwhile (a number from 0 to 3.1416)"""


@dataclass(kw_only=True, slots=True)
class SimulationRealismTurnedOptions(OptionGroup):
    """The group ``turned``."""

    on: bool = False
    """whether it happens; --realism sets it"""


@dataclass(kw_only=True, slots=True)
class SimulationRealismBentOptions(OptionGroup):
    """The group ``bent``."""

    on: bool = False
    """whether it happens; --realism sets it"""
    amplitude_m: float = 0.25
    """how far walls leave their lines (a number from 0 to 5)"""
    wavelength_m: float = 25.0
    """over what length (a number from 5 to 1000)"""


@dataclass(kw_only=True, slots=True)
class SimulationRealismMovedOptions(OptionGroup):
    """The group ``moved``."""

    on: bool = False
    """whether it happens; --realism sets it"""
    every_s: float = 60.0
    """between one state of the world and the next (a number from 1 to 1000000)"""
    share: float = 0.2
    """of things that have been moved in each (a number from 0 to 1)"""
    distance_m: float = 0.7
    """by up to so far (a number from 0 to 5)"""


@dataclass(kw_only=True, slots=True)
class SimulationRealismStandersOptions(OptionGroup):
    """The group ``standers``."""

    on: bool = False
    """whether it happens; --realism sets it"""
    count: int = 12
    """of them (a whole number from 0 to 1000)"""


@dataclass(kw_only=True, slots=True)
class SimulationRealismWalkersOptions(OptionGroup):
    """The group ``walkers``."""

    on: bool = False
    """whether it happens; --realism sets it"""
    count: int = 12
    """of them (a whole number from 0 to 1000)"""


@dataclass(kw_only=True, slots=True)
class SimulationRealismFollowerOptions(OptionGroup):
    """The group ``follower``."""

    on: bool = False
    """whether it happens; --realism sets it"""
    from_s: float = 5.0
    """when it begins (a number from 0 to 1000000)"""
    to_s: float = 0.0
    """when it ends; 0: never (a number from 0 to 1000000)"""
    gap_m: float = 0.4
    """behind the robot's centre, along its way (a number from 0 to 20)"""
    aside_m: float = 0.65
    """to its left, where walls leave room (a number from -5 to 5)"""
    body_m: float = 0.0
    """radius of what the laser sees of each: a coat, a waist; 0: two legs (a number from 0 to 1)
    """


@dataclass(kw_only=True, slots=True)
class SimulationRealismAheadOptions(OptionGroup):
    """The group ``ahead``."""

    on: bool = False
    """whether it happens; --realism sets it"""
    from_s: float = 5.0
    """when it begins (a number from 0 to 1000000)"""
    to_s: float = 0.0
    """when it ends; 0: never (a number from 0 to 1000000)"""
    gap_m: float = 1.2
    """ahead of the robot's centre, along its way (a number from 0.3 to 20)"""
    body_m: float = 0.0
    """radius of what the laser sees of each: a coat, a waist; 0: two legs (a number from 0 to 1)
    """


@dataclass(kw_only=True, slots=True)
class SimulationRealismCrowdOptions(OptionGroup):
    """The group ``crowd``."""

    on: bool = False
    """whether it happens; --realism sets it"""
    from_s: float = 30.0
    """when it begins (a number from 0 to 1000000)"""
    to_s: float = 60.0
    """when it ends; 0: never (a number from 0 to 1000000)"""
    count: int = 8
    """of people (a whole number from 0 to 100)"""
    radius_m: float = 0.9
    """of the ring in which they stand (a number from 0.4 to 20)"""
    body_m: float = 0.2
    """radius of what the laser sees of each: a coat, a waist; 0: two legs (a number from 0 to 1)
    """


@dataclass(kw_only=True, slots=True)
class SimulationRealismGlassOptions(OptionGroup):
    """The group ``glass``."""

    on: bool = False
    """whether it happens; --realism sets it"""
    share: float = 0.12
    """of the walls, in panes of a metre (a number from 0 to 1)"""
    returns_within_rad: float = 0.2
    """incidence, from the normal, up to which a pane is seen (a number from 0 to 1.5708)"""


@dataclass(kw_only=True, slots=True)
class SimulationRealismMirrorsOptions(OptionGroup):
    """The group ``mirrors``."""

    on: bool = False
    """whether it happens; --realism sets it"""
    share: float = 0.03
    """of the walls, in panes of a metre (a number from 0 to 1)"""


@dataclass(kw_only=True, slots=True)
class SimulationRealismOptions(OptionGroup):
    """The group ``realism``."""

    range: SimulationRealismRangeOptions = _field(default_factory=SimulationRealismRangeOptions)
    mixed: SimulationRealismMixedOptions = _field(default_factory=SimulationRealismMixedOptions)
    dropouts: SimulationRealismDropoutsOptions = _field(
        default_factory=SimulationRealismDropoutsOptions
    )
    steps: SimulationRealismStepsOptions = _field(default_factory=SimulationRealismStepsOptions)
    sweep: SimulationRealismSweepOptions = _field(default_factory=SimulationRealismSweepOptions)
    mount: SimulationRealismMountOptions = _field(default_factory=SimulationRealismMountOptions)
    blocked: SimulationRealismBlockedOptions = _field(
        default_factory=SimulationRealismBlockedOptions
    )
    dirty: SimulationRealismDirtyOptions = _field(default_factory=SimulationRealismDirtyOptions)
    upside_down: SimulationRealismUpsideDownOptions = _field(
        default_factory=SimulationRealismUpsideDownOptions
    )
    stamps: SimulationRealismStampsOptions = _field(default_factory=SimulationRealismStampsOptions)
    loss: SimulationRealismLossOptions = _field(default_factory=SimulationRealismLossOptions)
    wheels: SimulationRealismWheelsOptions = _field(default_factory=SimulationRealismWheelsOptions)
    gyro: SimulationRealismGyroOptions = _field(default_factory=SimulationRealismGyroOptions)
    rolling: SimulationRealismRollingOptions = _field(
        default_factory=SimulationRealismRollingOptions
    )
    uneven: SimulationRealismUnevenOptions = _field(default_factory=SimulationRealismUnevenOptions)
    carried: SimulationRealismCarriedOptions = _field(
        default_factory=SimulationRealismCarriedOptions
    )
    carried_blind: SimulationRealismCarriedBlindOptions = _field(
        default_factory=SimulationRealismCarriedBlindOptions
    )
    turned: SimulationRealismTurnedOptions = _field(default_factory=SimulationRealismTurnedOptions)
    bent: SimulationRealismBentOptions = _field(default_factory=SimulationRealismBentOptions)
    moved: SimulationRealismMovedOptions = _field(default_factory=SimulationRealismMovedOptions)
    standers: SimulationRealismStandersOptions = _field(
        default_factory=SimulationRealismStandersOptions
    )
    walkers: SimulationRealismWalkersOptions = _field(
        default_factory=SimulationRealismWalkersOptions
    )
    follower: SimulationRealismFollowerOptions = _field(
        default_factory=SimulationRealismFollowerOptions
    )
    ahead: SimulationRealismAheadOptions = _field(default_factory=SimulationRealismAheadOptions)
    crowd: SimulationRealismCrowdOptions = _field(default_factory=SimulationRealismCrowdOptions)
    glass: SimulationRealismGlassOptions = _field(default_factory=SimulationRealismGlassOptions)
    mirrors: SimulationRealismMirrorsOptions = _field(
        default_factory=SimulationRealismMirrorsOptions
    )


@dataclass(kw_only=True, slots=True)
class SimulationOptions(CallOptions):
    """Of ``loopstone.simulate``."""

    _of: ClassVar[str] = "simulate"

    duration_s: float = 0.0
    """cuts the drive; 0: the whole route (a number from 0 to 1000000)"""
    start_s: float = 1000.0
    """stamp of the first moment (a number from 0 to 4000000000)"""
    people: int = 0
    """people who walk about (a whole number from 0 to 1000)"""
    odometry_poses: bool = False
    """the robot's own dead reckoning instead of counts and imu, as CARMEN logs it"""
    drive: SimulationDriveOptions = _field(default_factory=SimulationDriveOptions)
    laser: SimulationLaserOptions = _field(default_factory=SimulationLaserOptions)
    wheels: SimulationWheelsOptions = _field(default_factory=SimulationWheelsOptions)
    imu: SimulationImuOptions = _field(default_factory=SimulationImuOptions)
    camera: SimulationCameraOptions = _field(default_factory=SimulationCameraOptions)
    faults: SimulationFaultsOptions = _field(default_factory=SimulationFaultsOptions)
    realism: SimulationRealismOptions = _field(default_factory=SimulationRealismOptions)
