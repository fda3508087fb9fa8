//! Coefficients of the Rosenbrock methods, in the transformed form of Hairer and Wanner.

/// A Rosenbrock method whose last stage is the error of the one before it, as in all of RODAS.
pub struct Tableau {
    /// Order of the solution that is kept.
    pub order: usize,
    /// Diagonal of the stages.
    pub gamma: f64,
    /// Weights of earlier stages in a stage's state, row by stage.
    pub a: &'static [&'static [f64]],
    /// Weights of earlier stages in a stage's residual, row by stage.
    pub c: &'static [&'static [f64]],
    /// Time of each stage within the step.
    pub alpha: &'static [f64],
    /// Weight of the derivative by time.
    pub d: &'static [f64],
    /// Weights of the stages in the dense output, row by power.
    pub dense: &'static [&'static [f64]],
}

impl Tableau {
    /// Number of stages.
    pub fn stages(&self) -> usize {
        self.alpha.len()
    }
}

/// RODAS4. Source: Hairer and Wanner (1996), Solving Ordinary Differential Equations II, IV.10,
/// coefficients of their code RODAS, method 1; order 4, dense output of order 3.
pub static RODAS4: Tableau = Tableau {
    order: 4,
    gamma: 0.25,
    a: &[
        &[],
        &[1.544],
        &[0.946_678_528_081_582_6, 0.255_701_169_898_328_4],
        &[3.314_825_187_068_521, 2.896_124_015_972_201, 0.998_641_913_997_781_7],
        &[1.221_224_509_226_641, 6.019_134_481_288_629, 12.537_083_329_320_87, -0.687_886_036_105_895],
        &[1.221_224_509_226_641, 6.019_134_481_288_629, 12.537_083_329_320_87, -0.687_886_036_105_895, 1.0],
    ],
    c: &[
        &[],
        &[-5.6688],
        &[-2.430_093_356_833_875, -0.206_359_915_709_191_5],
        &[-0.107_352_905_815_137_5, -9.594_562_251_023_355, -20.470_286_148_096_16],
        &[7.496_443_313_967_647, -10.246_804_314_643_52, -33.999_903_528_199_05, 11.708_908_932_061_6],
        &[
            8.083_246_795_921_522,
            -7.981_132_988_064_893,
            -31.521_594_328_743_71,
            16.319_305_431_231_36,
            -6.058_818_238_834_054,
        ],
    ],
    alpha: &[0.0, 0.386, 0.21, 0.63, 1.0, 1.0],
    d: &[0.25, -0.1043, 0.1035, -0.0362, 0.0, 0.0],
    dense: &[
        &[
            10.126_235_083_445_86,
            -7.487_995_877_610_167,
            -34.800_918_615_557_47,
            -7.992_771_707_568_823,
            1.025_137_723_295_662,
        ],
        &[
            -0.676_280_339_280_125_3,
            6.087_714_651_680_015,
            16.430_843_208_924_78,
            24.767_225_114_183_86,
            -6.594_389_125_716_872,
        ],
    ],
};
