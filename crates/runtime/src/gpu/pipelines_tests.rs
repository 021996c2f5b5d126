use super::super::adapter::device;
use super::*;
use crate::passes::Pass;

#[test]
fn what_a_failed_call_compiled_is_compiled_again_by_all_and_nothing_else_is() {
    let Some((device, _)) = device() else { return };
    let mut one = Pipelines::new(&device, None);
    let [a, b] = [Pass::Bounds, Pass::Speed].map(Form::from);
    one.get(&a);
    one.keep();
    let mut other = one.share();
    one.get(&b);
    [&a, &b].into_iter().for_each(|form| _ = other.get(form));
    assert_eq!([one.compiled.pipelines, other.compiled.pipelines], [2, 0]);
    one.forget();
    [&a, &b].into_iter().for_each(|form| _ = other.get(form));
    assert_eq!([one.compiled.pipelines, other.compiled.pipelines], [2, 1], "the second alone");
    other.keep();
    [&a, &b].into_iter().for_each(|form| _ = one.get(form));
    assert_eq!(one.compiled.pipelines, 2, "the other has compiled it again");
    // A stepper whose construction fails is dropped.
    let form = Form::from(Pass::Fastest);
    one.share().get(&form);
    assert!(!one.shared.has(&form) && one.shared.has(&b));
}
