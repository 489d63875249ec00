//! rust_peer LOG PACE: tells the sensors of a simulated drive, a log of CARMEN, by RustDDS and
//! ros2-client, and hears what comes of it. In the end a line of JSON says what came.

use std::{
    env, fs, thread,
    time::{Duration, Instant},
};

use ros2_client::{
    qos::{Durability, History, WhenFull},
    Context, MessageTypeName, Name, Node, NodeName, NodeOptions, Publisher, QosProfile,
    Subscription,
};
use serde::{de::DeserializeOwned, Deserialize, Serialize};

#[derive(Serialize, Deserialize, Clone, Debug, Default)]
struct Time {
    sec: i32,
    nanosec: u32,
}
#[derive(Serialize, Deserialize, Clone, Debug, Default)]
struct Header {
    stamp: Time,
    frame_id: String,
}
#[derive(Serialize, Deserialize, Clone, Debug, Default)]
struct Vector3 {
    x: f64,
    y: f64,
    z: f64,
}
#[derive(Serialize, Deserialize, Clone, Debug, Default)]
struct Quaternion {
    x: f64,
    y: f64,
    z: f64,
    w: f64,
}
/// Also a Transform.
#[derive(Serialize, Deserialize, Clone, Debug, Default)]
struct Pose {
    position: Vector3,
    orientation: Quaternion,
}
/// Also a TwistWithCovariance.
#[derive(Serialize, Deserialize, Clone, Debug, Default)]
struct PoseWithCovariance {
    pose: Pose,
    covariance: [[f64; 6]; 6],
}
#[derive(Serialize, Deserialize, Clone, Debug, Default)]
struct Twist {
    linear: Vector3,
    angular: Vector3,
    covariance: [[f64; 6]; 6],
}
#[derive(Serialize, Deserialize, Clone, Debug, Default)]
struct PoseWithCovarianceStamped {
    header: Header,
    pose: PoseWithCovariance,
}
#[derive(Serialize, Deserialize, Clone, Debug, Default)]
struct Odometry {
    header: Header,
    child_frame_id: String,
    pose: PoseWithCovariance,
    twist: Twist,
}
#[derive(Serialize, Deserialize, Clone, Debug, Default)]
struct TransformStamped {
    header: Header,
    child_frame_id: String,
    transform: Pose,
}
#[derive(Serialize, Deserialize, Clone, Debug, Default)]
struct TFMessage {
    transforms: Vec<TransformStamped>,
}
#[derive(Serialize, Deserialize, Clone, Debug, Default)]
struct LaserScan {
    header: Header,
    angle_min: f32,
    angle_max: f32,
    angle_increment: f32,
    time_increment: f32,
    scan_time: f32,
    range_min: f32,
    range_max: f32,
    ranges: Vec<f32>,
    intensities: Vec<f32>,
}
#[derive(Serialize, Deserialize, Clone, Debug, Default)]
struct OccupancyGrid {
    header: Header,
    map_load_time: Time,
    resolution: f32,
    width: u32,
    height: u32,
    origin: Pose,
    data: Vec<i8>,
}

/// From the first beam to the last one, of the simulated laser; CARMEN's text does not tell it.
const SWEEP_S: f64 = 0.01875;

fn header(seconds: f64, frame: &str) -> Header {
    let nanoseconds = (seconds * 1e9).round() as i64;
    Header {
        stamp: Time {
            sec: (nanoseconds / 1_000_000_000) as i32,
            nanosec: (nanoseconds % 1_000_000_000) as u32,
        },
        frame_id: frame.to_string(),
    }
}

fn seconds_of(time: &Time) -> f64 {
    f64::from(time.sec) + f64::from(time.nanosec) * 1e-9
}

fn pose(x: f64, y: f64, yaw: f64) -> Pose {
    Pose {
        position: Vector3 { x, y, z: 0.0 },
        orientation: Quaternion {
            x: 0.0,
            y: 0.0,
            z: (yaw / 2.0).sin(),
            w: (yaw / 2.0).cos(),
        },
    }
}

fn transform(seconds: f64, parent: &str, child: &str, transform: Pose) -> TFMessage {
    TFMessage {
        transforms: vec![TransformStamped {
            header: header(seconds, parent),
            child_frame_id: child.to_string(),
            transform,
        }],
    }
}

fn quality(reliable: bool, latched: bool, depth: usize) -> QosProfile {
    let profile = QosProfile::publisher_default().history(History::KeepLast { depth });
    let profile = if reliable {
        profile.reliability_reliable(WhenFull::DEFAULT)
    } else {
        profile.reliability_best_effort()
    };
    profile.durability(if latched {
        Durability::TransientLocal
    } else {
        Durability::Volatile
    })
}

fn publisher<M: Serialize>(
    node: &mut Node,
    name: &str,
    kind: (&str, &str),
    profile: QosProfile,
) -> Publisher<M> {
    let topic = node
        .create_topic(
            &Name::new("/", name).unwrap(),
            MessageTypeName::new(kind.0, kind.1),
            &profile,
        )
        .unwrap();
    node.create_publisher::<M>(&topic, None).unwrap()
}

fn subscription<M: DeserializeOwned + 'static>(
    node: &mut Node,
    name: &str,
    kind: (&str, &str),
    profile: QosProfile,
) -> Subscription<M> {
    let topic = node
        .create_topic(
            &Name::new("/", name).unwrap(),
            MessageTypeName::new(kind.0, kind.1),
            &profile,
        )
        .unwrap();
    node.create_subscription::<M>(&topic, None).unwrap()
}

struct Robot {
    scans: Publisher<LaserScan>,
    odometry: Publisher<Odometry>,
    moving: Publisher<TFMessage>,
    fixed: Publisher<TFMessage>,
    laser_x: f64,
}

impl Robot {
    fn tell(&mut self, seconds: f64, words: &[&str]) {
        let number = |i: usize| words[i].parse::<f64>().unwrap();
        match words[0] {
            "PARAM" if words[1] == "robot_frontlaser_offset" => {
                self.laser_x = number(2);
                let mount = transform(seconds, "base_link", "laser", pose(self.laser_x, 0.0, 0.0));
                self.fixed.publish(mount).unwrap();
            }
            "ODOM" => {
                let odom_to_base = pose(number(1), number(2), number(3));
                self.moving
                    .publish(transform(seconds, "odom", "base_link", odom_to_base.clone()))
                    .unwrap();
                let mut message = Odometry {
                    header: header(seconds, "odom"),
                    child_frame_id: "base_link".to_string(),
                    ..Default::default()
                };
                message.pose.pose = odom_to_base;
                self.odometry.publish(message).unwrap();
            }
            "ROBOTLASER1" => {
                let count = words[8].parse::<usize>().unwrap();
                let message = LaserScan {
                    header: header(seconds, "laser"),
                    angle_min: number(2) as f32,
                    angle_max: (number(2) + number(3)) as f32,
                    angle_increment: number(4) as f32,
                    time_increment: (SWEEP_S / count as f64) as f32,
                    range_min: 0.05,
                    range_max: number(5) as f32,
                    ranges: (9..9 + count).map(|i| number(i) as f32).collect(),
                    ..Default::default()
                };
                self.scans.publish(message).unwrap();
            }
            _ => {}
        }
    }
}

#[derive(Default)]
struct Heard {
    maps: usize,
    width: u32,
    height: u32,
    cells: usize,
    poses: usize,
    transforms: usize,
    last: (f64, f64, f64),
}

struct Ears {
    maps: Subscription<OccupancyGrid>,
    poses: Subscription<PoseWithCovarianceStamped>,
    transforms: Subscription<TFMessage>,
}

impl Ears {
    fn listen(&self, heard: &mut Heard) {
        while let Ok(Some((map, _))) = self.maps.take() {
            heard.maps += 1;
            heard.width = map.width;
            heard.height = map.height;
            heard.cells = map.data.len();
        }
        while let Ok(Some((one, _))) = self.poses.take() {
            heard.poses += 1;
            let at = &one.pose.pose.position;
            heard.last = (seconds_of(&one.header.stamp), at.x, at.y);
        }
        while let Ok(Some((message, _))) = self.transforms.take() {
            heard.transforms += message
                .transforms
                .iter()
                .filter(|one| one.header.frame_id == "map" && one.child_frame_id == "odom")
                .count();
        }
    }
}

fn main() {
    let words: Vec<String> = env::args().collect();
    let log = fs::read_to_string(&words[1]).unwrap();
    let pace: f64 = words[2].parse().unwrap();
    let mut node = Context::new()
        .unwrap()
        .new_node(
            NodeName::new("/", "rust_peer").unwrap(),
            NodeOptions::new(),
        )
        .unwrap();
    let tf = ("tf2_msgs", "TFMessage");
    let mut robot = Robot {
        scans: publisher(&mut node, "scan", ("sensor_msgs", "LaserScan"), quality(false, false, 5)),
        odometry: publisher(&mut node, "odom", ("nav_msgs", "Odometry"), quality(true, false, 10)),
        moving: publisher(&mut node, "tf", tf, quality(true, false, 100)),
        fixed: publisher(&mut node, "tf_static", tf, quality(true, true, 1)),
        laser_x: 0.0,
    };
    let ears = Ears {
        maps: subscription(&mut node, "map", ("nav_msgs", "OccupancyGrid"), quality(true, true, 1)),
        poses: subscription(
            &mut node,
            "pose",
            ("geometry_msgs", "PoseWithCovarianceStamped"),
            quality(true, false, 10),
        ),
        transforms: subscription(&mut node, "tf", tf, quality(true, false, 100)),
    };
    thread::sleep(Duration::from_secs(2)); // until all have found each other
    let mut heard = Heard::default();
    let begin = Instant::now();
    let mut first = None;
    for line in log.lines().filter(|line| !line.starts_with('#')) {
        let words: Vec<&str> = line.split_whitespace().collect();
        let seconds: f64 = words[words.len() - 1].parse().unwrap();
        let since = seconds - *first.get_or_insert(seconds);
        let due = Duration::from_secs_f64(since.max(0.0) / pace);
        thread::sleep(due.saturating_sub(begin.elapsed()));
        robot.tell(seconds, &words);
        ears.listen(&mut heard);
    }
    let end = Instant::now();
    while end.elapsed() < Duration::from_secs(3) {
        thread::sleep(Duration::from_millis(20));
        ears.listen(&mut heard);
    }
    println!(
        "{{\"maps\": {}, \"width\": {}, \"height\": {}, \"cells\": {}, \"poses\": {}, \
         \"transforms\": {}, \"last\": [{}, {}, {}]}}",
        heard.maps,
        heard.width,
        heard.height,
        heard.cells,
        heard.poses,
        heard.transforms,
        heard.last.0,
        heard.last.1,
        heard.last.2
    );
}
