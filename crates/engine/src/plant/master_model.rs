use super::model::{Machine, Model};
use super::{ArmParameters, MasterParameters, PlantError};
use trocar_core::settings::ActsFor;

trocar_core::choice! {
    /// Model of the master without its controller and the arm.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum MasterModel at "master.model" = Appendix {
        "appendix" => Appendix,
        "mass-damper" => MassDamper,
        "transfer-function" => TransferFunction,
        "state-space" => StateSpace,
    }
}

const GENERAL: ActsFor = ActsFor::all_but(MasterModel::KEY.path, MasterModel::WORDS, "appendix");

trocar_core::settings! {
    #[derive(Debug, Clone, PartialEq)]
    pub struct MasterModelSettings in "master." no const {
        model: MasterModel,
        /// Coulomb friction of the mass, which holds it at rest up to this force; 0: none.
        coulomb_friction_n: f64 [NON_NEGATIVE] for MasterModel::MassDamper = 0.0,
        /// Numerator from force to position, highest power first.
        numerator: Vec<f64> for MasterModel::TransferFunction = [1.0],
        /// Denominator from force to position, highest power first; degree 2 to 8.
        denominator: Vec<f64> for MasterModel::TransferFunction = [0.245, 4.1, 0.0],
        /// Matrix A of the state-space model, row by row: n x n.
        a: Vec<f64> for MasterModel::StateSpace = [0.0, 1.0, 0.0, -16.7],
        /// Matrix B of the state-space model, row by row: n x 2, for the motor's force and the hand's force in N, both in
        /// the direction of insertion.
        b: Vec<f64> for MasterModel::StateSpace = [0.0, 0.0, 4.1, 4.1],
        /// Row C of the state-space model: n numbers, from the states to the position in m.
        c: Vec<f64> for MasterModel::StateSpace = [1.0, 0.0],
        /// Constant external force on the master in the direction of insertion, for example its weight.
        constant_force_n: f64 [ANY] for (GENERAL) = 0.0,
    }
}

impl MasterModelSettings {
    pub fn is_general(&self) -> bool {
        self.model != MasterModel::Appendix
    }

    pub fn has_coulomb_friction(&self) -> bool {
        self.model == MasterModel::MassDamper && self.coulomb_friction_n > 0.0
    }
}

#[derive(Debug, Clone, Copy)]
pub struct GeneralMaster<'a> {
    pub parameters: &'a MasterParameters,
    pub model: &'a MasterModelSettings,
    pub arm: &'a ArmParameters,
}

impl GeneralMaster<'_> {
    /// Without controller, arm and Coulomb friction.
    pub fn machine(&self) -> Result<Machine, PlantError> {
        let Self { parameters, model, arm } = self;
        parameters.validate()?;
        model.validate()?;
        arm.validate()?;
        let described = match model.model {
            MasterModel::Appendix | MasterModel::MassDamper => {
                Model::MassDamper { mass_kg: parameters.mass_kg, damping_n_s_per_m: parameters.damping_n_s_per_m }
            }
            MasterModel::TransferFunction => {
                Model::Function { numerator: &model.numerator, denominator: &model.denominator }
            }
            MasterModel::StateSpace => Model::Matrices { a: &model.a, b: &model.b, c: &model.c },
        };
        Machine::described("master", described)
    }
}
