//! Facts that several tests read of every shader. To parse all of them takes most of the time of such a test, and the modules
//! a gibibyte, so that each text is parsed once and its module is let go.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::OnceLock;

use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{AddressSpace, Module, StorageAccess, TypeInner};

use super::loops_tests::check;
use super::tests::{module, variants};
use super::*;

pub(super) struct Facts {
    /// The fault that naga finds, if one.
    pub fault: Option<String>,
    /// Index, name, and whether the shader writes it, of each variable that is bound.
    pub bound: BTreeSet<(u32, String, bool)>,
    /// Groups of these.
    pub groups: BTreeSet<u32>,
    /// Bound variables that are not uniform.
    pub storage: u32,
    pub overrides: BTreeSet<String>,
    pub structs: Vec<Struct>,
    /// How many loops there are, and the functions of which one loads before it decides whether to go on.
    pub loops: (usize, BTreeSet<String>),
}

pub(super) struct Struct {
    pub name: Option<String>,
    /// Names of its members, and where they lie in bytes.
    pub members: Vec<(String, u32)>,
    pub span: u32,
}

/// Facts of every variant.
pub(super) fn facts() -> impl Iterator<Item = (&'static Form, &'static Facts)> {
    /// Forms with places in the list of facts.
    type All = (Vec<(Form, usize)>, Vec<Facts>);
    static ALL: OnceLock<All> = OnceLock::new();
    let (forms, facts) = ALL.get_or_init(|| {
        let (mut facts, mut places) = (Vec::new(), BTreeMap::new());
        let place = |form: Form| {
            let at = *places.entry(source(&form).text()).or_insert_with_key(|text| {
                facts.push(read(&module(&form), text));
                facts.len() - 1
            });
            (form, at)
        };
        let forms = variants().into_iter().map(place).collect();
        (forms, facts)
    });
    forms.iter().map(|(form, at)| (form, &facts[*at]))
}

fn read(module: &Module, text: &str) -> Facts {
    let valid = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(module);
    let (mut bound, mut groups, mut storage) = (BTreeSet::new(), BTreeSet::new(), 0);
    for (_, variable) in module.global_variables.iter() {
        let Some(binding) = &variable.binding else { continue };
        let writes =
            matches!(variable.space, AddressSpace::Storage { access } if access.contains(StorageAccess::STORE));
        storage += u32::from(variable.space != AddressSpace::Uniform);
        groups.insert(binding.group);
        bound.insert((binding.binding, variable.name.clone().unwrap(), writes));
    }
    let members = |members: &[naga::StructMember]| {
        members.iter().map(|m| (m.name.clone().unwrap(), m.offset)).collect::<Vec<_>>()
    };
    let structs = module.types.iter().filter_map(|(_, ty)| match &ty.inner {
        TypeInner::Struct { members: all, span } => {
            Some(Struct { name: ty.name.clone(), members: members(all), span: *span })
        }
        _ => None,
    });
    Facts {
        fault: valid.err().map(|e| e.emit_to_string(text)),
        bound,
        groups,
        storage,
        overrides: module.overrides.iter().filter_map(|(_, o)| o.name.clone()).collect(),
        structs: structs.collect(),
        loops: check(module),
    }
}
