// SPDX-License-Identifier: Apache-2.0
//! A ROS 2 node by another implementation of DDS: publishes what a hand senses again and again, at
//! 100 Hz and with stamps of the present, and listens to what is estimated.
//!
//! usage: rustdds_peer DOMAIN SENSED.json POSES SECONDS
//!
//! SENSED.json has lists of messages, {"joint_states": [..], "tf": [..], "contacts": {FINGER: [..]}}.
//! Ends after so many poses or seconds, and prints what was sent and what came.

mod messages;

use std::collections::BTreeMap;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use messages::*;
use rustdds::no_key::{DataReaderCdr, DataWriter};
use rustdds::policy::{Durability, History, Reliability};
use rustdds::{CDRSerializerAdapter, DomainParticipant, DomainParticipantBuilder, QosPolicies};
use rustdds::{QosPolicyBuilder, TopicKind};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

const TICK: Duration = Duration::from_millis(10);

#[derive(Deserialize)]
struct Sensed {
    joint_states: Vec<JointState>,
    tf: Vec<TFMessage>,
    contacts: BTreeMap<String, Vec<PointCloud2>>,
}

#[derive(Serialize, Default)]
struct Report {
    sent: usize,
    acknowledged: bool,
    poses: usize,
    of_what_was_sent: usize,
    position: [f64; 3],
    variance: f64,
    frame: String,
    status: String,
}

struct Node {
    participant: DomainParticipant,
    qos: QosPolicies,
}

impl Node {
    fn new(domain: u16) -> Self {
        let participant = DomainParticipantBuilder::new(domain).build().expect("no participant");
        let qos = QosPolicyBuilder::new()
            .reliability(Reliability::Reliable { max_blocking_time: rustdds::Duration::from_secs(1) })
            .durability(Durability::Volatile)
            .history(History::KeepLast { depth: 1000 })
            .build();
        Self { participant, qos }
    }

    fn topic(&self, name: &str, kind: &str) -> rustdds::Topic {
        let (package, message) = kind.split_once('/').expect("package/Message");
        self.participant
            .create_topic(
                format!("rt{name}"),
                format!("{package}::msg::dds_::{message}_"),
                &self.qos,
                TopicKind::NoKey,
            )
            .expect(name)
    }

    fn writer<M: Serialize>(&self, name: &str, kind: &str) -> DataWriter<M, CDRSerializerAdapter<M>> {
        let publisher = self.participant.create_publisher(&self.qos).expect("no publisher");
        publisher.create_datawriter_no_key_cdr(&self.topic(name, kind), None).expect(name)
    }

    fn reader<M: DeserializeOwned + 'static>(&self, name: &str, kind: &str) -> DataReaderCdr<M> {
        let subscriber = self.participant.create_subscriber(&self.qos).expect("no subscriber");
        subscriber.create_datareader_no_key_cdr(&self.topic(name, kind), None).expect(name)
    }
}

fn now() -> Time {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).expect("a clock before 1970");
    Time { sec: since.as_secs() as i32, nanosec: since.subsec_nanos() }
}

/// All that has come since the last call.
fn take<M: DeserializeOwned + Clone + 'static>(reader: &mut DataReaderCdr<M>) -> Vec<M> {
    let mut taken = Vec::new();
    while let Ok(Some(sample)) = reader.take_next_sample() {
        taken.push(sample.into_value());
    }
    taken
}

fn main() {
    let words: Vec<String> = std::env::args().collect();
    let [_, domain, path, poses, seconds] = &words[..] else {
        eprintln!("usage: rustdds_peer DOMAIN SENSED.json POSES SECONDS");
        std::process::exit(2);
    };
    let text = std::fs::read_to_string(path).expect(path);
    let sensed: Sensed = serde_json::from_str(&text).expect(path);
    let report = play(
        &Node::new(domain.parse().expect("DOMAIN")),
        &sensed,
        poses.parse().expect("POSES"),
        Duration::from_secs_f64(seconds.parse().expect("SECONDS")),
    );
    println!("{}", serde_json::to_string(&report).expect("a report"));
}

fn play(node: &Node, sensed: &Sensed, enough: usize, limit: Duration) -> Report {
    let joints = node.writer::<JointState>("/joint_states", "sensor_msgs/JointState");
    let tf = node.writer::<TFMessage>("/tf", "tf2_msgs/TFMessage");
    let contacts: Vec<_> = sensed
        .contacts
        .iter()
        .map(|(finger, clouds)| {
            (node.writer(&format!("/contacts/{finger}"), "sensor_msgs/PointCloud2"), clouds)
        })
        .collect();
    let mut estimates = node.reader::<PoseWithCovarianceStamped>(
        "/palpate/estimate",
        "geometry_msgs/PoseWithCovarianceStamped",
    );
    let mut status = node.reader::<StringMessage>("/palpate/status", "std_msgs/String");
    let mut stamps = std::collections::HashSet::new();
    let mut report = Report::default();
    let start = Instant::now();
    while report.poses < enough && start.elapsed() < limit {
        let stamp = now();
        let i = report.sent;
        let mut transforms = sensed.tf[i % sensed.tf.len()].clone();
        transforms.transforms.iter_mut().for_each(|t| t.header.stamp = stamp);
        tf.write(transforms, None).expect("/tf");
        for (writer, clouds) in &contacts {
            let mut cloud: PointCloud2 = clouds[i % clouds.len()].clone();
            cloud.header.stamp = stamp;
            writer.write(cloud, None).expect("/contacts");
        }
        let mut state = sensed.joint_states[i % sensed.joint_states.len()].clone();
        state.header.stamp = stamp;
        joints.write(state, None).expect("/joint_states");
        report.sent += 1;
        stamps.insert((stamp.sec, stamp.nanosec));
        std::thread::sleep((TICK * report.sent as u32).saturating_sub(start.elapsed()));
        for estimate in take(&mut estimates) {
            let p = estimate.pose.position;
            let of = (estimate.header.stamp.sec, estimate.header.stamp.nanosec);
            report.poses += 1;
            report.of_what_was_sent += usize::from(stamps.contains(&of));
            report.position = [p.x, p.y, p.z];
            report.variance = estimate.covariance[0][0];
            report.frame = estimate.header.frame_id;
        }
        if let Some(last) = take(&mut status).pop() {
            report.status = last.data;
        }
    }
    report.acknowledged =
        joints.wait_for_acknowledgments(Duration::from_secs(5)).unwrap_or(false);
    report
}
