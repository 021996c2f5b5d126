//! Fabrics by name.

use super::Material;

/// A fabric: tension along the warp and the weft, shear \[N/m\], bending \[N m\], density \[kg/m^2\], damping \[1/s\], half
/// the thickness \[m\], friction.
type Row = (&'static str, [f64; 8]);

/// Round numbers in the middle of what is measured; one fabric differs from the next of its name by a factor of two or more.
///
/// Shear and bending are those of S. Kawabata's tests (KES-F 1 to 4; "The Standardization and Analysis of Hand Evaluation",
/// Osaka 1980): bending of .03 to .05 gf cm for silk, .05 to .1 for shirting, .1 to .15 for suiting, .5 to 1 for denim (1 gf cm
/// is 9.8e-5 N m per curvature of 1/m and width of 1 m); shear of .3, .9, .8 and 4 gf/cm per degree (1 of these is 56 N/m).
/// Tension of woven fabric is that at strains of one to three per cent, as in H. Wang, J. O'Brien, R. Ramamoorthi,
/// "Data-Driven Elastic Models for Cloth", SIGGRAPH 2011; it rises beyond. Leather is garment nappa of .9 mm with a modulus of 5
/// MPa at small strain, rubber a sheet of .5 mm with 1.5 MPa (L. Treloar, "The Physics of Rubber Elasticity", 1975), bending
/// of both is E t^3 / 12. Felt is of pressed wool, 3 mm.
const FABRICS: [Row; 7] = [
    ("silk", [800.0, 600.0, 17.0, 4e-6, 0.07, 0.5, 1e-4, 0.7]),
    ("cotton", [1000.0, 800.0, 50.0, 7e-6, 0.12, 0.5, 1.5e-4, 1.0]),
    ("denim", [3000.0, 2000.0, 220.0, 7e-5, 0.4, 0.5, 4e-4, 1.2]),
    ("wool", [700.0, 500.0, 45.0, 1.2e-5, 0.22, 0.5, 2.5e-4, 1.2]),
    ("leather", [4500.0, 4500.0, 1500.0, 3e-4, 0.65, 1.0, 4.5e-4, 1.3]),
    ("felt", [1500.0, 1500.0, 500.0, 1e-3, 0.6, 1.0, 1.5e-3, 1.5]),
    ("rubber", [750.0, 750.0, 250.0, 1.6e-5, 0.48, 1.0, 2.5e-4, 2.5]),
];

impl Material {
    /// The fabrics that [`Material::named`] knows.
    pub fn names() -> impl Iterator<Item = &'static str> {
        FABRICS.iter().map(|(name, _)| *name)
    }

    /// A fabric by name: silk, cotton, denim, wool, leather, felt, rubber. Typical values; their sources stand in
    /// `material/fabric.rs`. Stiff fabrics in few substeps are softer than they should be.
    ///
    /// ```
    /// use gimage_runtime::Material;
    ///
    /// let stiffer = Material { bend: 1e-4, ..Material::named("denim").unwrap() };
    /// assert!(stiffer.check().is_ok() && Material::named("chain mail").is_none());
    /// ```
    pub fn named(name: &str) -> Option<Self> {
        let (_, numbers) = FABRICS.iter().find(|(known, _)| *known == name)?;
        let [warp, weft, shear, bend, density, damping, thickness, friction] = *numbers;
        Some(Material { warp, weft, shear, bend, density, damping, thickness: Some(thickness), friction })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fabrics_are_valid_and_in_the_order_of_their_feel() {
        assert_eq!(Material::names().count(), 7);
        let all: Vec<Material> = Material::names().map(|name| Material::named(name).unwrap()).collect();
        all.iter().for_each(|fabric| fabric.check().unwrap());
        let of = |name| Material::named(name).unwrap();
        // A tape of its own weight bends under it at this length [m], which orders how fabrics drape.
        let drape = |m: Material| (m.bend / (m.density * 9.81)).cbrt();
        let order = ["silk", "cotton", "denim", "felt"].map(|name| drape(of(name)));
        assert!(order.is_sorted() && order[0] > 0.01 && order[3] < 0.1, "{order:?}");
        assert!(of("silk").density < of("wool").density && of("wool").density < of("leather").density);
        assert!(Material::named("Silk").is_none());
    }
}
