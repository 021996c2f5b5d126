use super::*;
use crate::{Cloth, Compliance, Flat};

#[test]
fn placeholder() {
    let mut cloth = Flat::square("x", 9).cloth().unwrap();
    cloth.set_material(&Material::default()).unwrap();
    let Compliance::Image(soft) = &cloth.compliance else { panic!() };
    println!("{:?} {:?}", soft[10], soft[0]);
    println!("{:?}", cloth.bending().unwrap().weights[30]);
    println!("{:?}", cloth.bending().unwrap().compliance);
    println!("{:?}", cloth.bending().unwrap().bounds(&cloth)[40]);
}
