//! A loop decides whether it ends before it loads anything that invocations share.
//!
//! Mesa's llvmpipe runs several invocations as one vector. A load from a storage buffer (or from workgroup memory) gives 0
//! to the invocations that have already left the loop, and a value that is loaded in a loop and used behind it is that of
//! the loop's last turn: 0 for each invocation that took fewer turns than its neighbours. No such use has to be written
//! down. A load of the same address behind the loop is replaced by the one inside, if every way out of the loop passes it:
//! with `m < starts[ring + 1u]` as the condition of two loops, the second loop of a short ring made no turn at all. A load
//! behind the first exit is on no way out of the loop, so that its value stays inside. Seen with Mesa 22.3.6 through
//! OpenGL; compilers that keep values in registers per invocation have no such fault.

use std::collections::BTreeSet;

use naga::{AddressSpace, Block, Expression, Function, Handle, Module, Statement};

use super::facts_tests::facts;

/// The first effect of a statement.
#[derive(Clone, Copy, Debug, PartialEq)]
enum First {
    Nothing,
    Loads,
    /// Leaves the loop on some way, without a load before it.
    Leaves,
}

struct Reader<'a> {
    module: &'a Module,
    function: &'a Function,
}

impl Reader<'_> {
    /// Whether a pointer leads to what invocations share.
    fn shared(&self, pointer: Handle<Expression>) -> bool {
        match self.function.expressions[pointer] {
            Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => self.shared(base),
            Expression::GlobalVariable(variable) => {
                let space = self.module.global_variables[variable].space;
                matches!(space, AddressSpace::Storage { .. } | AddressSpace::WorkGroup)
            }
            _ => false,
        }
    }

    /// Whether a function loads anything shared, on any way through it.
    fn calls_a_load(&self, callee: Handle<Function>) -> bool {
        let function = &self.module.functions[callee];
        let reader = Reader { function, ..*self };
        reader.loads(&function.body)
    }

    fn loads(&self, block: &Block) -> bool {
        block.iter().any(|statement| match statement {
            Statement::Block(block) => self.loads(block),
            Statement::If { accept, reject, .. } => self.loads(accept) || self.loads(reject),
            Statement::Switch { cases, .. } => cases.iter().any(|c| self.loads(&c.body)),
            Statement::Loop { body, continuing, .. } => self.loads(body) || self.loads(continuing),
            other => self.statement(other, false) == First::Loads,
        })
    }

    /// The first load or exit of a block; `inside` the loop, or a loop or a switch in it, where `break` is not the loop's.
    fn block(&self, block: &Block, inside: bool) -> First {
        block.iter().map(|s| self.statement(s, inside)).find(|f| *f != First::Nothing).unwrap_or(First::Nothing)
    }

    fn statement(&self, statement: &Statement, inside: bool) -> First {
        let loads = |yes| if yes { First::Loads } else { First::Nothing };
        // Of alternatives a load counts, whichever way leaves.
        let any = |blocks: &[(&Block, bool)]| {
            let each: Vec<_> = blocks.iter().map(|(b, inside)| self.block(b, *inside)).collect();
            let found = |what| each.contains(&what).then_some(what);
            found(First::Loads).or(found(First::Leaves)).unwrap_or(First::Nothing)
        };
        match statement {
            Statement::Emit(range) => loads(range.clone().any(|e| match self.function.expressions[e] {
                Expression::Load { pointer } => self.shared(pointer),
                _ => false,
            })),
            Statement::Atomic { pointer, .. } | Statement::WorkGroupUniformLoad { pointer, .. } => {
                loads(self.shared(*pointer))
            }
            Statement::Call { function, .. } => loads(self.calls_a_load(*function)),
            Statement::Block(block) => self.block(block, inside),
            Statement::If { accept, reject, .. } => any(&[(accept, inside), (reject, inside)]),
            Statement::Switch { cases, .. } => any(&cases.iter().map(|c| (&c.body, false)).collect::<Vec<_>>()),
            Statement::Loop { body, continuing, .. } => any(&[(body, false), (continuing, false)]),
            Statement::Break if inside => First::Leaves,
            Statement::Return { .. } => First::Leaves,
            _ => First::Nothing,
        }
    }

    /// Every loop of a block, however deep, and whether it loads before its first exit.
    fn loops(&self, block: &Block, found: &mut Vec<bool>) {
        for statement in block.iter() {
            match statement {
                Statement::Block(block) => self.loops(block, found),
                Statement::If { accept, reject, .. } => [accept, reject].iter().for_each(|b| self.loops(b, found)),
                Statement::Switch { cases, .. } => cases.iter().for_each(|c| self.loops(&c.body, found)),
                Statement::Loop { body, continuing, .. } => {
                    let first = [body, continuing].map(|b| self.block(b, true));
                    found.push(first.into_iter().find(|f| *f != First::Nothing) == Some(First::Loads));
                    self.loops(body, found);
                    self.loops(continuing, found);
                }
                _ => {}
            }
        }
    }
}

/// How many loops a module has, and the functions with loops that load before they decide whether to go on.
pub(super) fn check(module: &Module) -> (usize, BTreeSet<String>) {
    let (mut count, mut wrong) = (0, BTreeSet::new());
    let entries = module.entry_points.iter().map(|e| &e.function);
    for function in module.functions.iter().map(|(_, f)| f).chain(entries) {
        let mut found = Vec::new();
        Reader { module, function }.loops(&function.body, &mut found);
        count += found.len();
        wrong.extend(found.contains(&true).then(|| function.name.clone().unwrap_or_default()));
    }
    (count, wrong)
}

#[test]
fn loops_decide_whether_to_go_on_before_they_load() {
    let mut count = 0;
    let mut wrong = BTreeSet::new();
    for (form, facts) in facts() {
        let (loops, functions) = &facts.loops;
        count += loops;
        wrong.extend(functions.iter().map(|f| format!("{}: {f}", super::source(form).stem)));
    }
    assert!(count > 1000, "{count} loops");
    assert!(wrong.is_empty(), "load the value before the loop, or in the turn before: {wrong:#?}");
}

#[test]
fn a_load_before_the_first_exit_is_found_wherever_it_hides() {
    let head = "@group(0) @binding(0) var<storage, read> list: array<u32>;
        @group(0) @binding(1) var<storage, read_write> out: array<u32>;
        var<workgroup> held: array<u32, 64>;
        fn end(k: u32) -> u32 { if (k > 9u) { return 0u; } return list[k]; }
        fn indirect(k: u32) -> u32 { return end(k) + 1u; }";
    let wrong = |body: &str| {
        let text = format!("{head} fn run(k: u32) -> u32 {{ var m = k; {body} return m; }}");
        let module = naga::front::wgsl::parse_str(&text).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&text)));
        let (count, wrong) = check(&module);
        assert_eq!(count, 1, "{body}");
        !wrong.is_empty()
    };
    let bad = [
        "for (; m < list[k]; m++) {}",
        "while (m < end(k)) { m++; }",
        "while (m < indirect(k)) { m++; }",
        "while (m < 9u && m < list[k]) { m++; }",
        "while (m < held[k]) { m++; }",
        "loop { m = list[m]; if (m == k) { break; } }",
        "loop { if (list[m] == k) { break; } m++; }",
        "loop { if (m > k) { m += list[m]; } if (m == k) { break; } }",
        "loop { m++; continuing { break if m == list[m]; } }",
        "loop { let n = list[m]; if (n == k) { return n; } m++; }",
    ];
    bad.iter().for_each(|body| assert!(wrong(body), "{body}"));
    let good = [
        "let last = list[k]; for (; m < last; m++) { out[m] = list[m]; }",
        "var more = list[m] < k; while (more) { m++; more = list[m] < k; }",
        "while (m < arrayLength(&list)) { m += list[m]; }",
        "loop { if (m == k) { break; } let n = list[m]; if (n == k) { break; } m = n; }",
        "loop { if (m == k) { return m; } m += end(m); }",
    ];
    good.iter().for_each(|body| assert!(!wrong(body), "{body}"));
}
