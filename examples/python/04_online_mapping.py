"""Builds a map while a robot drives; a real one hands its messages over as they come."""

import loopstone as ls

drive = ls.simulate("office", duration_s=60.0, laser__beams=361)
mapper = ls.Mapper(drive.robot)
for message in drive:
    for update in mapper.add(message):
        for event in update.events:
            if event.closure is not None and event.closure.stands:
                print(
                    f"  submap {event.closure.to_submap} is where {event.closure.from_submap} was"
                )
        if update.scan % 100 == 0:
            x, y, _ = update.map_T_robot
            print(f"({x:6.2f}, {y:6.2f}) m, {update.status}")
            mapper.live_map().to_grid().save("live_map.yaml")

result = mapper.finish()
print(len(result.trajectory), "scans;", result.verdict)
