//! Devices that are lost: errors instead of panics, and cloths that go on with another device.

// The test has a number of frames of its own.
#[allow(dead_code)]
#[path = "../examples/crowd.rs"]
mod crowd;
use crate::support::rig::{FRAME, Rig, largest};
use crate::support::{self, curtain, made_of, two_charts};
use gimage_runtime::*;

fn options() -> Options {
    Options { substeps: Some(3), ..Options::default() }
}

fn start() -> Scene {
    let mut scene = support::scene(curtain(12));
    scene.cloths.extend([made_of(two_charts(7)), curtain(40)]);
    scene.colliders.push(Collider::new(Shape::Sphere { radius: 0.2 }, [0.5, -0.4, 0.1]));
    scene
}

fn bits(rig: &Rig) -> Vec<[Vec<[u32; 4]>; 3]> {
    let of = |list: Vec<[f32; 4]>| list.into_iter().map(|p| p.map(f32::to_bits)).collect();
    let cloth = |c| [rig.positions(c), rig.previous(c), rig.normals(c)].map(of);
    (0..rig.stepper.handles().len()).map(cloth).collect()
}

fn cut(stepper: &mut Stepper) -> Result<()> {
    stepper.cut([0.6, -0.45, 3.0], [0.3, -0.45, -2.0], [5.0, -0.45, -2.0])
}

#[test]
fn the_crowd_example_runs() {
    if support::device().is_some() {
        crowd::run(24).unwrap();
    }
}

#[test]
fn another_device_goes_on_from_the_last_state_on_the_host() {
    let (Some(first), Some(second)) = (support::device(), support::device()) else { return };
    let mut rig = Rig::gpu(start(), &options(), &first);
    let handles = rig.stepper.handles().to_vec();
    rig.frames(4);
    cut(&mut rig.stepper).unwrap();
    let added = rig.stepper.add_cloth(curtain(9)).unwrap();
    rig.frames(3);
    let saved = rig.stepper.snapshot().unwrap();
    // Changes after it are lost, with a pin that waits.
    rig.frames(2);
    rig.stepper.remove_cloth(handles[0]).unwrap();
    rig.stepper.pin(handles[1], &[20]).unwrap();
    let span = rig.stepper.buffers(0).unwrap().now.clone();
    let mut encoder = first.0.create_command_encoder(&Default::default());
    let ticket = rig.stepper.record_pick(&mut encoder, [0.0; 3], [0.0, 0.0, 1.0]).unwrap();
    first.1.submit([encoder.finish()]);
    first.0.destroy();

    // Every call that needs the device returns the error, before and after the device has noticed.
    for polled in [false, true] {
        if polled {
            first.0.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        }
        let mut encoder = first.0.create_command_encoder(&Default::default());
        let place = first.0.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: 1 << 16,
            usage: wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let stepper = &mut rig.stepper;
        let errors = [
            stepper.record(&mut encoder, FRAME).map(|_| ()),
            stepper.settle(),
            stepper.state(0).map(|_| ()),
            stepper.snapshot().map(|_| ()),
            stepper.set_state(0, &saved.cloths()[1]),
            stepper.add_cloth(curtain(5)).map(|_| ()),
            stepper.set_colliders(Vec::new()),
            stepper.set_collision_groups(0, 1),
            stepper.record_bounds(&mut encoder),
            stepper.index_buffer(0).map(|_| ()),
            stepper.record_tangents(&mut encoder, 0).map(|_| ()),
            stepper.set_options(Options { thickness: 0.01, ..options() }),
            cut(stepper),
            stepper.record_pick(&mut encoder, [0.0; 3], [0.0, 0.0, 1.0]).map(|_| ()),
            stepper.record_state(&mut encoder, 0, &place, 0).map(|_| ()),
            stepper.another(start(), options()).map(|_| ()),
            Stepper::new(start(), options(), Some((&first.0, &first.1))).map(|_| ()),
            read_back(&first.0, &first.1, &span).map(|_| ()),
            ticket.wait(&first.0).map(|_| ()),
            stepper.recover(&first.0, &first.1),
        ];
        for (n, error) in errors.into_iter().enumerate() {
            assert!(matches!(error, Err(Error::DeviceLost)), "{n}: {error:?}");
        }
        assert_eq!((stepper.scene().colliders.len(), stepper.handles().len()), (1, 3), "nothing has changed");
    }
    rig.recover(&second);
    assert_eq!(rig.stepper.handles(), [handles[1], handles[2], added]);
    let mut other = rig.another(&start());
    other.stepper.add_cloth(curtain(9)).unwrap();
    other.stepper.restore(&saved).unwrap();
    other.stepper.remove_cloth(0).unwrap();
    for rig in [&mut rig, &mut other] {
        rig.frames(5);
        rig.stepper.set_wind(Some(support::wind(true))).unwrap();
        rig.frames(2);
    }
    assert!(bits(&rig) == bits(&other));
}

#[test]
fn boxes_triangles_and_tangents_are_made_again() {
    let (Some(first), Some(second)) = (support::device(), support::device()) else { return };
    let options = Options { fused: false, ..options() };
    let mut start = support::scene(two_charts(7));
    start.cloths.push(curtain(9));
    let mut rig = Rig::gpu(start, &options, &first);
    let keep = rig.stepper.handle(1).unwrap();
    // Asks for all that a renderer needs, and returns the tangents.
    let ask = |stepper: &mut Stepper, (device, queue): &(wgpu::Device, wgpu::Queue)| {
        let mut encoder = device.create_command_encoder(&Default::default());
        stepper.index_buffer(keep)?;
        stepper.record_bounds(&mut encoder)?;
        let tangents = stepper.record_tangents(&mut encoder, keep)?;
        queue.submit([encoder.finish()]);
        Ok::<_, Error>(tangents)
    };
    cut(&mut rig.stepper).unwrap();
    rig.frame(FRAME);
    let torn = rig.stepper.state(keep).unwrap();
    ask(&mut rig.stepper, &first).unwrap();
    rig.stepper.settle().unwrap();
    ask(&mut rig.stepper, &first).unwrap();
    // Boxes are under way twice: the first ones are being mapped, the second ones are only copied.
    first.0.destroy();
    assert!(matches!(ask(&mut rig.stepper, &first), Err(Error::DeviceLost)));
    assert!(matches!(rig.stepper.settle(), Err(Error::DeviceLost)));
    assert_eq!(rig.stepper.bounds(keep), None);
    rig.stepper.remove_cloth(0).unwrap();
    first.0.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    assert!(matches!(rig.stepper.settle(), Err(Error::DeviceLost)));
    rig.recover(&second);
    rig.stepper.settle().unwrap();
    let buffers = rig.stepper.buffers(keep).unwrap();
    assert!(buffers.indices.is_none() && buffers.tangents.is_none() && rig.stepper.bounds(keep).is_none());

    let mut twin = Rig::cpu(support::scene(curtain(9)), &options);
    twin.stepper.set_state(0, &torn).unwrap();
    twin.frame(FRAME);
    rig.stepper.index_buffer(keep).unwrap();
    rig.frame(FRAME);
    let tangents = ask(&mut rig.stepper, &second).unwrap();
    rig.stepper.settle().unwrap();
    second.0.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    rig.stepper.settle().unwrap();
    let (found, expected) = (rig.stepper.bounds(keep).unwrap(), twin.stepper.bounds(0).unwrap());
    let apart = (0..3).map(|c| (found.low[c] - expected.low[c]).abs().max((found.high[c] - expected.high[c]).abs()));
    assert!(apart.fold(0.0, f32::max) < 1e-5 && found.age == 0.0, "{found:?} {expected:?}");
    let tangents = read_back(&second.0, &second.1, &tangents).unwrap();
    assert!(largest(&tangents, &twin.stepper.tangents(0).unwrap()) < 1e-3);
    let indices = read_back_u32(&second.0, &second.1, &rig.stepper.index_buffer(keep).unwrap()).unwrap();
    let triangles = indices.chunks_exact(3).filter(|t| t[0] != t[1] || t[0] != t[2]).flatten().copied();
    assert_eq!(triangles.collect::<Vec<_>>(), twin.stepper.indices(0).unwrap());
    assert!(twin.stepper.indices(0).unwrap().len() < curtain(9).indices().len());
}

#[test]
fn cloth_without_a_state_begins_again_and_the_cpu_loses_nothing() {
    let devices = [(); 3].map(|()| support::device());
    let [Some(first), Some(second), Some(third)] = devices else { return };
    let mut rig = Rig::gpu(start(), &options(), &first);
    rig.frames(3);
    let one = rig.stepper.state(1).unwrap();
    rig.frames(2);
    cut(&mut rig.stepper).unwrap();
    rig.stepper.teleport(0, &scene::Pose { position: [1.0, 0.0, 0.0], ..Default::default() }).unwrap();
    rig.frames(2);
    first.0.destroy();
    rig.recover(&second);
    rig.frame(0.0);
    let mut fresh = rig.another(&start());
    fresh.stepper.set_state(1, &one).unwrap();
    fresh.frame(0.0);
    assert!(bits(&rig) == bits(&fresh) && rig.holes(0).is_none());

    let on_cpu = Options { backend: Backend::Cpu, ..options() };
    let mut stepper = Stepper::new(start(), on_cpu, Some((&second.0, &second.1))).unwrap();
    let mut alone = Rig::cpu(start(), &options());
    let frame = |stepper: &mut Stepper, device: &(wgpu::Device, wgpu::Queue)| {
        let mut encoder = device.0.create_command_encoder(&Default::default());
        stepper.record(&mut encoder, FRAME)?;
        device.1.submit([encoder.finish()]);
        Ok::<(), Error>(())
    };
    frame(&mut stepper, &second).unwrap();
    cut(&mut stepper).unwrap();
    frame(&mut stepper, &second).unwrap();
    second.0.destroy();
    assert!(matches!(frame(&mut stepper, &second), Err(Error::DeviceLost)));
    stepper.recover(&third.0, &third.1).unwrap();
    frame(&mut stepper, &third).unwrap();
    alone.frame(FRAME);
    cut(&mut alone.stepper).unwrap();
    alone.frames(2);
    for cloth in 0..3 {
        assert_eq!(stepper.positions(cloth), alone.stepper.positions(cloth));
        let buffers = stepper.buffers(cloth).unwrap();
        let drawn = read_back(&third.0, &third.1, &buffers.now).unwrap();
        assert_eq!(Some(&drawn[..]), alone.stepper.positions(cloth));
        let holes = read_back_u32(&third.0, &third.1, buffers.holes.as_ref().unwrap()).unwrap();
        assert_eq!(Some(&holes[..]), alone.stepper.holes(cloth));
    }
    let error = alone.stepper.recover(&third.0, &third.1).unwrap_err();
    assert!(matches!(error, Error::NoGpu(_)));
}
