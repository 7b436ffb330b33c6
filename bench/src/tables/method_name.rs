//! The names of methods, in the order in which methods are listed.

use situ::method::{self, Role};

/// A method, in the order in which methods are listed; methods that are not listed follow by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct MethodName<'a> {
    rank: usize,
    pub(super) name: &'a str,
}

/// The listed methods and what they do with a changed task.
pub(super) struct Methods(Vec<(&'static str, Role)>);

impl Methods {
    pub(super) fn listed() -> Self {
        Self(method::all().iter().map(|method| (method.name(), method.role())).collect())
    }

    pub(super) fn name<'a>(&self, name: &'a str) -> MethodName<'a> {
        let rank = self.0.iter().position(|(listed, _)| *listed == name).unwrap_or(self.0.len());
        MethodName { rank, name }
    }

    /// A method that is not listed takes corrections.
    pub(super) fn role(&self, name: &str) -> Role {
        self.0.iter().find(|(listed, _)| *listed == name).map_or(Role::Correct, |(_, role)| *role)
    }
}
