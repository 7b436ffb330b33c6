//! What is observed of an episode that is served, key for key.

use serde_json::{Value, json};
use situ_sim::GripperCommand;
use situ_tasks::Pose;

use super::served::Served;

/// A pose: metres, world frame.
fn pose(pose: &Pose) -> Value {
    let position: [f64; 3] = pose.translation.vector.into();
    let rotation = &pose.rotation;
    json!({"position": position, "quaternion_wxyz": [rotation.w, rotation.i, rotation.j, rotation.k]})
}

fn gripper(command: GripperCommand) -> Value {
    match command {
        GripperCommand::Open(metres) => json!({"open": metres}),
        GripperCommand::Close(newtons) => json!({"close": newtons}),
    }
}

/// The names and scales of the observed state.
pub(super) fn features<'a>(features: impl Iterator<Item = (&'a str, f64)>) -> Value {
    features.map(|(name, scale)| json!({"name": name, "scale": scale})).collect()
}

/// The observation of an episode.
pub(super) fn observation(served: &Served) -> Value {
    let (episode, world, seen) = (&served.episode, served.episode.world(), served.episode.seen());
    let (state, schema) = (episode.observe(), served.schema().features());
    let scaled: Vec<f64> = state.iter().zip(schema).map(|(value, feature)| value / feature.scale).collect();
    let object = |name: &str| {
        let mut keys = world.pose(name).map_or(Value::Null, |found| pose(&found));
        if let Some(keys) = keys.as_object_mut() {
            keys.insert("name".to_owned(), name.into());
            keys.insert("seen".to_owned(), seen.pose(name).map_or(Value::Null, |found| pose(&found)));
        }
        keys
    };
    let setting = served.setting();
    let role = |name: &str| json!({"name": name, "object": episode.view().object(name)});
    json!({
        "features": features(schema.iter().map(|feature| (feature.name.as_str(), feature.scale))),
        "state": state,
        "scaled": scaled,
        "objects": setting.objects.iter().map(|placed| object(&placed.body.name)).collect::<Value>(),
        "roles": setting.roles.iter().map(|own| role(&own.name)).collect::<Value>(),
        "hand": pose(&world.tcp()),
        "opening": world.opening(),
        "gripper": gripper(world.gripper()),
        "seconds": episode.seconds(),
        "keyframes": served.deeds.len(),
        "events": episode.events_fired(),
        "solved": episode.succeeded(),
        "truncated": served.is_truncated(),
    })
}
