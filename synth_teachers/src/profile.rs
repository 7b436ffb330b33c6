//! Teacher profiles: how often a teacher errs, and how. They are read from a file.

use std::path::Path;

use serde::Deserialize;
use situ_tasks::key::Document;
use situ_tasks::{FileKind, name};
use toml::Spanned;

use crate::error::TeacherError;
use crate::extent::{Detour, Extent, Misaligned, Noise, Pause, Size, Spread};

/// Declares the ways of erring. Each line gives the variant of [`Way`], the key in a [`Profile`] and what stands there,
/// and what the rate is a share of.
macro_rules! ways {
    ($($(#[$meaning:meta])* $way:ident = $key:ident: $extent:ty, $of:literal;)*) => {
        /// A way of erring that happens or does not. Noise always happens, so it is none.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Way { $($(#[$meaning])* $way),* }

        impl Way {
            /// All of them.
            pub const ALL: [Way; [$(Way::$way),*].len()] = [$(Way::$way),*];

            /// The key that profile files use.
            pub const fn name(self) -> &'static str {
                match self { $(Way::$way => stringify!($key)),* }
            }

            /// What the rate is a share of.
            pub const fn unit(self) -> &'static str {
                match self { $(Way::$way => $of),* }
            }
        }

        /// The errors of a teacher: for each [`Way`] its rate, with its size where it has one. All zero is the expert.
        #[derive(Clone, Debug, PartialEq, Deserialize)]
        #[serde(deny_unknown_fields)]
        pub struct Profile {
            /// Its name.
            pub name: String,
            /// The teacher that it stands for, in prose.
            pub analysis: String,
            /// Noise where the gripper touches something.
            #[serde(default)]
            pub contact: Noise,
            /// Noise in free space.
            #[serde(default)]
            pub free: Noise,
            /// How much one grasp of a thing differs from another.
            #[serde(default)]
            pub grasp: Spread,
            $($(#[$meaning])* #[serde(default)] pub $key: $extent,)*
        }

        impl Profile {
            fn extent(&self, way: Way) -> &dyn Extent {
                match way { $(Way::$way => &self.$key),* }
            }
        }
    };
}

ways! {
    /// A needless keyframe, half way and off the path by the free noise.
    Spurious = spurious: f64, "keyframes";
    /// A free keyframe that is passed but not recorded. One with a gripper command is never missed: the command records
    /// it.
    Missing = missing: f64, "free keyframes";
    /// A pause to think at a keyframe.
    Pause = pause: Pause, "keyframes";
    /// An excursion before a keyframe: out to somewhere that is of no use, and recorded.
    Detour = detour: Detour, "keyframes";
    /// A way to a keyframe along one axis after the other, with a recorded keyframe at each corner.
    OneAxis = one_axis: f64, "keyframes";
    /// A skill performed with the gripper turned about its own axis.
    Misaligned = misaligned: Misaligned, "skills";
    /// A thing taken from another side: with the gripper a quarter turned about its own axis, either way.
    OtherSide = other_side: f64, "grasps";
    /// A thing taken with the gripper half turned about its own axis: the fingers change places.
    HalfTurn = half_turn: f64, "grasps";
    /// A skill whose reference object is named wrongly: another object of the scene, all equally likely.
    WrongReference = wrong_reference: f64, "skills";
    /// A skill begun without a word, where it is about the object that was named last: it becomes part of the segment
    /// before it.
    Unannounced = unannounced: f64, "skills";
    /// A correction that ends once the robot knows how to go on, instead of at the end of the task.
    StopsEarly = stops_early: f64, "corrections";
    /// A correction that begins one primitive too early: the robot is stopped before it has gone wrong.
    BeginsEarly = begins_early: f64, "corrections";
    /// A correction that begins too late: the first moment at which the robot should have been stopped passes.
    BeginsLate = begins_late: f64, "corrections";
}

impl Profile {
    /// The configured rate of a way of erring, from 0 to 1.
    pub fn rate(&self, way: Way) -> f64 {
        self.extent(way).rate()
    }

    /// Whether this teacher takes things in other ways than the script does.
    pub(crate) fn varies_grasps(&self) -> bool {
        self.grasp != Spread::default() || self.other_side > 0.0 || self.half_turn > 0.0
    }

    /// Err with a key and what is wrong with its value.
    fn check(&self) -> Result<(), String> {
        if let Some(problem) = name::mistake(&self.name) {
            return Err(format!("`name` is {problem}"));
        }
        let below = |key: &str, part: Option<&str>| part.map_or(key.to_owned(), |part| format!("{key}.{part}"));
        for way in Way::ALL {
            let rate = self.rate(way);
            if !(0.0..=1.0).contains(&rate) {
                let key = below(way.name(), self.extent(way).rate_key());
                return Err(format!("`{key}` is {rate}, expected a rate from 0 to 1"));
            }
        }
        if self.begins_early + self.begins_late > 1.0 {
            return Err(format!(
                "`begins_early` and `begins_late` are {} together, expected at most 1: no correction is both",
                self.begins_early + self.begins_late
            ));
        }
        if self.grasp != Spread::default() && self.grasp.freedom == 0 {
            return Err("`grasp.freedom` is 0, expected 1 to 255 degrees of freedom".to_owned());
        }
        let noise = [("contact", self.contact), ("free", self.free)];
        let noise = noise.iter().flat_map(|(key, noise)| noise.sizes().map(|size| (*key, size)));
        let noise = noise.chain(self.grasp.sizes().map(|size| ("grasp", size)));
        let errors = Way::ALL.iter().filter_map(|way| Some((way.name(), self.extent(*way).size()?)));
        let mut sizes = noise.chain(errors);
        match sizes.find(|(_, size)| !(0.0..=size.most).contains(&size.value)) {
            Some((key, Size { key: part, value, unit, most })) => {
                Err(format!("`{}` is {value}, expected 0 to {most} {unit}", below(key, Some(part))))
            }
            None => Ok(()),
        }
    }

    /// Reads profiles from the text of a file; `path` is for messages.
    ///
    /// # Errors
    /// [`TeacherError::File`] with the line, and what was expected.
    pub fn parse(text: &str, path: &Path) -> Result<Vec<Self>, TeacherError> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let refuse = |offset: usize, problem: String| TeacherError::File {
            path: path.to_owned(),
            line: text[..offset.min(text.len())].matches('\n').count() + 1,
            problem: name::shown(&problem),
        };
        // What is no TOML is said below.
        if let Ok(document) = Document::parse(text, path) {
            document.check_kind(FileKind::Teachers)?;
        }
        let file: File = toml::from_str(text)
            .map_err(|error| refuse(error.span().map_or(0, |span| span.start), error.message().to_owned()))?;
        for (index, spanned) in file.profile.iter().enumerate() {
            let (offset, profile) = (spanned.span().start, spanned.as_ref());
            profile
                .check()
                .map_err(|problem| refuse(offset, format!("profile `{}`: {problem}", profile.name.escape_debug())))?;
            if file.profile[..index].iter().any(|other| other.as_ref().name == profile.name) {
                return Err(refuse(offset, format!("profile `{}` appears twice, expected unique names", profile.name)));
            }
        }
        Ok(file.profile.into_iter().map(Spanned::into_inner).collect())
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    profile: Vec<Spanned<Profile>>,
}
