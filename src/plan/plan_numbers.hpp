#pragma once

namespace loopstone {

/// What lines and their corners are found by.
struct PlanLineNumbers {
  double occupied_percent = 65.0;
  double support_m = 0.08;
  double spacing_m = 0.03;
  double range_max_m = 20.0;
  int points_max = 1200;
  double scans_common_m = 0.002;
  double piece_m = 0.1;
  int sectors = 8;
  int least_scans = 3;
  int least_samples = 8;
  double across_m = 0.035;
  double gap_m = 0.25;
  double end_cell_m = 0.02;
  double short_m = 0.2;
  double short_facing = 0.97;
  double facing_deg = 22.0;
  double least_length_m = 0.08;
  double correlated_m = 0.3;
  double across_spreads = 3.0;
  double across_most_m = 0.08;
  double axis_sigmas = 2.5;
  double axis_most_deg = 1.0;
  double axis_least_share = 0.12;
  double corner_m = 0.12;
  double corner_deg = 20.0;
};
inline constexpr PlanLineNumbers kPlan{};

template <typename Visitor>
void visit_numbers(const PlanLineNumbers& n, Visitor&& visit) {
  visit("occupied_percent", n.occupied_percent, "derived: map_server's threshold");
  visit("support_m", n.support_m,
        "chosen: neighbours that make a return's normal; less than a door's jamb is deep");
  visit("spacing_m", n.spacing_m, "chosen: between samples of one scan");
  visit("range_max_m", n.range_max_m,
        "chosen: what is seen from farther is seen at a flat angle or with few beams");
  visit("points_max", n.points_max, "chosen: as many as a fine laser has beams");
  visit("scans_common_m", n.scans_common_m,
        "measured by bench/plans.py: what all scans of a wall have in common, by their poses and "
        "the laser's bias");
  visit("piece_m", n.piece_m, "chosen: samples are joined to pieces of wall of this length");
  visit("sectors", n.sectors, "chosen: of the directions in which a cell's pieces face");
  visit("least_scans", n.least_scans, "chosen: a piece that fewer saw may be a passer-by");
  visit("least_samples", n.least_samples, "chosen: a line of fewer is none");
  visit("across_m", n.across_m,
        "chosen: pieces within this of a line belong to it: three times the noise of a laser");
  visit("gap_m", n.gap_m, "chosen: holes up to this do not part a line; a door is wider");
  visit("end_cell_m", n.end_cell_m,
        "chosen: ends of lines are looked for in cells of this size: twice a laser's noise");
  visit("short_m", n.short_m, "chosen: shorter lines may be but the round of a corner");
  visit("short_facing", n.short_facing,
        "chosen: unless they face one way: mean cosine, for a spread of about 14 deg");
  visit("facing_deg", n.facing_deg, "chosen: between a piece's normal and that of its line");
  visit("least_length_m", n.least_length_m, "chosen: a jamb is longer");
  visit("correlated_m", n.correlated_m,
        "chosen: pieces of a wall nearer to each other err together: plaster, skirting boards");
  visit("across_spreads", n.across_spreads,
        "derived: of a normal distribution all but a few in a thousand lie within three standard "
        "deviations");
  visit("across_most_m", n.across_most_m,
        "chosen: however wide samples spread, the two faces of a wall stay apart");
  visit("axis_sigmas", n.axis_sigmas,
        "derived: a wall that runs along an axis is turned from it by more in 1 of 80 cases");
  visit("axis_most_deg", n.axis_most_deg, "chosen: however uncertain, no line is turned by more");
  visit("axis_least_share", n.axis_least_share,
        "chosen: a direction with less of the walls' length is no axis");
  visit("corner_m", n.corner_m, "chosen: ends this near to where their lines meet are a corner");
  visit("corner_deg", n.corner_deg, "chosen: lines at a smaller angle meet nowhere in particular");
}

/// What walls, rooms and doors are told from other things by.
struct PlanRoomNumbers {
  double support_length_m = 2.4;
  double jamb_m = 0.6;
  double island_m = 3.0;
  double hidden_most_m = 4.5;
  double door_least_m = 0.55;
  double opening_most_m = 3.2;
  double wall_most_m = 0.6;
  double wall_usual_m = 0.32;
  double room_least_m2 = 1.2;
  double pocket_most_m2 = 8.0;
  double core_m = 0.12;
  double outline_m = 0.13;
  double thing_deep_m = 0.7;
};
inline constexpr PlanRoomNumbers kPlanRooms{};

template <typename Visitor>
void visit_numbers(const PlanRoomNumbers& n, Visitor&& visit) {
  visit("support_length_m", n.support_length_m,
        "chosen: what has this much surface in one plane is a wall; cupboards have less");
  visit("jamb_m", n.jamb_m, "chosen: thickness of a wall at the most");
  visit("island_m", n.island_m, "chosen: what stands free and is no larger is no structure");
  visit("hidden_most_m", n.hidden_most_m, "chosen: wall that furniture may hide in one piece");
  visit("door_least_m", n.door_least_m, "chosen: a narrower gap lets nobody through");
  visit("opening_most_m", n.opening_most_m,
        "chosen: where a wider one is left in a wall, there is one room on both sides");
  visit("wall_most_m", n.wall_most_m, "chosen: thickness of a wall at the most");
  visit("wall_usual_m", n.wall_usual_m,
        "chosen: two faces nearer to each other than this are of one wall: furniture before it is "
        "deeper");
  visit("room_least_m2", n.room_least_m2, "chosen: less is a niche");
  visit("pocket_most_m2", n.pocket_most_m2,
        "chosen: floor that furniture hides, which belongs to the room around it");
  visit("core_m", n.core_m,
        "chosen: what nobody saw this near behind a wall's face belongs to the wall");
  visit("outline_m", n.outline_m,
        "derived: a wall lies at most two cells and a half from where the floor ends");
  visit("thing_deep_m", n.thing_deep_m,
        "chosen: where a floor ends this near to a wall's line, a thing stands before the wall");
}

}  // namespace loopstone
