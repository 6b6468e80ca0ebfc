// Parameters of the detector, and the thesis' settings.
#include "analysis/anim_dog.h"

namespace kinemesh {

void DetectOptions::declare(ParameterSet& p) {
  p.group("features", "Detection of features");
  p.choice("filter", filter,
           {{SpatialFilter::ring, "ring", "mean over each vertex and its neighbours"},
            {SpatialFilter::cotangent, "cotangent", "diffusion that does not feel the triangles"}},
           "How deformation is smoothed over the surface");
  p.choice("norm", norm,
           {{ScaleNorm::thesis, "thesis", "σ² √τ and σ √τ³, in edges and frames"},
            {ScaleNorm::variance, "variance", "the same over the steps of variance"}},
           "How differences of scales are weighed");
  p.number("sigma", sigma,
           {.min = 1e-4,
            .max = 1.0,
            .help = "First spatial scale, as a part of the root of the surface's area"});
  p.number("sigma-levels", sigma_levels,
           {.min = 1, .max = 100, .help = "Number of spatial scales"});
  p.number("tau", tau,
           {.min = 1e-4, .max = 1.0, .help = "First temporal scale, as a part of the duration"});
  p.number("tau-levels", tau_levels, {.min = 1, .max = 100, .help = "Number of temporal scales"});
  p.number("scale-step", step, {.min = 1.01, .max = 4.0, .help = "Each scale over the one before"});
  p.number("smoothings", smoothings,
           {.min = 0,
            .max = 1000,
            .help = "Averagings over the surface with --filter ring; 0: from the largest blob"});
  p.number("time-smoothings", time_smoothings,
           {.min = 3, .max = 1000, .help = "Averagings over time with --filter ring"});
  p.flag("end-scales", end_scales, "Features may lie at the first and last scale");
  p.number(
      "apart", apart,
      {.min = 0.0,
       .max = 1.0,
       .help =
           "Weaker features nearer than this part of the diagonal to a stronger one are left out"});
  p.number(
      "apart-time", apart_time,
      {.min = 0.0, .max = 1.0, .help = "… if they are also nearer than this part of the duration"});
  p.number("threshold", threshold,
           {.min = 0.0, .max = 1.0, .help = "Least response, as a part of the strongest"});
  p.number("strongest", strongest,
           {.min = 0, .max = 1e9, .help = "Features to keep at most; 0: all"});
  p.number("memory", memory_mb,
           {.unit = "MB",
            .min = 10.0,
            .max = 1e6,
            .help = "Memory for the scale space; more is done in tiles"});
}

void set_thesis_preset(DeformationOptions& deformation, DetectOptions& detect) {
  deformation.region = StrainRegion::triangles;
  deformation.measure = StrainMeasure::lambda;
  deformation.position_smoothing = 0.0;
  deformation.curvature_weight = 7.0;
  deformation.curvature_unit = CurvatureUnit::edge;
  detect.filter = SpatialFilter::ring;
  detect.norm = ScaleNorm::thesis;
  detect.smoothings = 0;
  detect.time_smoothings = 54;
  detect.end_scales = false;
  detect.apart = detect.apart_time = 0.0;
  detect.threshold = 0.1;
  detect.strongest = 0;
}

}  // namespace kinemesh
