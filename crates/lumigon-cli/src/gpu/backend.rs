//! What renders: the CPU or a GPU, and what happens where the GPU does not.

use std::cell::{OnceCell, RefCell};

use clap::ValueEnum;
use lumigon_renderer::{
    BounceSettings, Camera, CpuRenderer, Gpu, GpuError, GpuPreference, GpuRenderer, RenderError,
    RenderSettings, Rendering, Scene, VirtualLights, Watch,
};

/// What is to compute closed forms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum BackendChoice {
    /// A hardware GPU where there is one that can do it, else the CPU
    #[default]
    Auto,
    /// The CPU
    Cpu,
    /// A GPU, software Vulkan included, or nothing
    Gpu,
}

/// A scene on what renders it.
pub(crate) struct Backend<'a> {
    scene: &'a Scene,
    choice: BackendChoice,
    /// Gone once it has failed.
    gpu: RefCell<Option<GpuBackend>>,
    cpu: OnceCell<CpuRenderer<'a>>,
    /// Why the CPU renders although a GPU was wanted.
    reason: RefCell<Option<String>>,
}

struct GpuBackend {
    renderer: GpuRenderer,
    name: String,
}

impl<'a> Backend<'a> {
    /// What `choice` comes to for this scene on this machine.
    ///
    /// # Errors
    /// Where nothing but a GPU will do, and there is none or it fails.
    pub(crate) fn new(choice: BackendChoice, scene: &'a Scene) -> Result<Self, RenderError> {
        let this = Self {
            scene,
            choice,
            gpu: RefCell::default(),
            cpu: OnceCell::new(),
            reason: RefCell::default(),
        };
        let preference = match choice {
            BackendChoice::Cpu => return Ok(this),
            BackendChoice::Auto => GpuPreference::Hardware,
            BackendChoice::Gpu => GpuPreference::Any,
        };
        match GpuBackend::new(preference, scene) {
            Ok(gpu) => _ = this.gpu.borrow_mut().insert(gpu),
            Err(error) if choice == BackendChoice::Gpu => return Err(error.into()),
            Err(error) => this.fall_back(&error),
        }
        Ok(this)
    }

    /// Renders with closed forms.
    ///
    /// # Errors
    /// As the renderers; a GPU's fault only where nothing but a GPU will do.
    pub(crate) fn render(
        &self,
        camera: &Camera,
        settings: &RenderSettings,
        watch: Watch<'_>,
    ) -> Result<Rendering, RenderError> {
        self.by_either(
            |gpu| gpu.render(camera, settings, watch),
            |cpu| cpu.render(camera, settings, watch),
        )
    }

    /// What the GPU does, or the CPU where there is none or it fails.
    fn by_either<T>(
        &self,
        on_gpu: impl FnOnce(&GpuRenderer) -> Result<T, RenderError>,
        on_cpu: impl FnOnce(&CpuRenderer<'a>) -> Result<T, RenderError>,
    ) -> Result<T, RenderError> {
        let by_gpu = self.gpu.borrow().as_ref().map(|gpu| on_gpu(&gpu.renderer));
        match by_gpu {
            Some(Err(RenderError::Gpu(error))) if self.choice == BackendChoice::Auto => {
                self.fall_back(&error);
            }
            Some(result) => return result,
            None => {}
        }
        on_cpu(self.cpu())
    }

    /// Finds the surfaces that light bounces off, and makes virtual lights of them.
    ///
    /// # Errors
    /// As [`Backend::render`].
    pub(crate) fn virtual_lights(
        &self,
        camera: &Camera,
        settings: &BounceSettings,
        watch: Watch<'_>,
    ) -> Result<VirtualLights, RenderError> {
        self.by_either(
            |gpu| gpu.virtual_lights(camera, settings, watch),
            |cpu| cpu.virtual_lights(camera, settings, watch),
        )
    }

    /// Renders with closed forms, lit by virtual lights too.
    ///
    /// # Errors
    /// As [`Backend::render`].
    pub(crate) fn render_with_bounce(
        &self,
        camera: &Camera,
        settings: &RenderSettings,
        lights: &VirtualLights,
        watch: Watch<'_>,
    ) -> Result<Rendering, RenderError> {
        self.by_either(
            |gpu| gpu.render_with_bounce(camera, settings, lights, watch),
            |cpu| cpu.render_with_bounce(camera, settings, lights, watch),
        )
    }

    /// The CPU's renderer, whatever renders closed forms: path tracing is its own.
    pub(crate) fn cpu(&self) -> &CpuRenderer<'a> {
        self.cpu.get_or_init(|| CpuRenderer::new(self.scene))
    }

    /// Lights that light nothing, and why.
    pub(crate) fn warnings(&self) -> Vec<String> {
        match &*self.gpu.borrow() {
            Some(gpu) => gpu.renderer.warnings().to_vec(),
            None => self.cpu().warnings().to_vec(),
        }
    }

    /// What rendered, and why where that was open.
    pub(crate) fn describe(&self) -> String {
        match (&*self.gpu.borrow(), &*self.reason.borrow()) {
            (Some(gpu), _) => format!("on the GPU {}", gpu.name),
            (None, Some(reason)) => format!("on the CPU ({reason})"),
            (None, None) => "on the CPU".to_owned(),
        }
    }

    /// From here on the CPU renders. That there is no GPU is no fault; that one fails is.
    fn fall_back(&self, error: &GpuError) {
        self.gpu.take();
        let reason = match error {
            GpuError::NoAdapter { .. } => "there is no hardware GPU",
            _ => {
                eprintln!("warning: {error}; the CPU renders instead");
                "the GPU failed"
            }
        };
        self.reason.replace(Some(reason.to_owned()));
    }
}

impl GpuBackend {
    fn new(preference: GpuPreference, scene: &Scene) -> Result<Self, GpuError> {
        let gpu = Gpu::new(preference)?;
        Ok(Self {
            renderer: GpuRenderer::new(&gpu, scene)?,
            name: gpu.adapter().name.clone(),
        })
    }
}
