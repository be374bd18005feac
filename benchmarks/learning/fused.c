/* The paper's loop without FMI: the physics of the four models, fused in one loop by the compiler.
 *
 * Each model.c is read with its names prefixed, so that one translation unit holds all of them.
 */
#include <stddef.h>

#include "laws/lugre/lugre.c"

#define JOIN(a, b) a##_##b
#define NAMED(a, b) JOIN(a, b)
#define Inputs NAMED(MODEL, Inputs)
#define States NAMED(MODEL, States)
#define Derivatives NAMED(MODEL, Derivatives)
#define Memory NAMED(MODEL, Memory)
#define Outputs NAMED(MODEL, Outputs)
#define Parameters NAMED(MODEL, Parameters)
#define Gradient NAMED(MODEL, Gradient)
#define Jacobian NAMED(MODEL, Jacobian)
#define sample NAMED(MODEL, sample)
#define model_start NAMED(MODEL, start)
#define model_step NAMED(MODEL, step)
#define model_sample NAMED(MODEL, due)
#define model_outputs NAMED(MODEL, outputs)
#define model_continuous NAMED(MODEL, continuous)
#define model_jacobian NAMED(MODEL, jacobian)
#define model_events NAMED(MODEL, events)
#define model_switch NAMED(MODEL, switch)

#define Law NAMED(MODEL, Law)
#define LawState NAMED(MODEL, LawState)
#define LawRate NAMED(MODEL, LawRate)
#define LawJacobian NAMED(MODEL, LawJacobian)
#define law_force NAMED(MODEL, law_force)
#define law_step NAMED(MODEL, law_step)
#define law_scaled NAMED(MODEL, law_scaled)
#define law_rate NAMED(MODEL, law_rate)
#define law_jacobian NAMED(MODEL, law_jacobian)
#define law_rows NAMED(MODEL, law_rows)

#define MODEL nominal
#define VARIABLES "nominal_loop/variables.h"
#include "nominal_loop/model.c"
#undef MODEL
#undef MODEL_H
#undef VARIABLES_H
#undef VARIABLES
#define MODEL compensator
#define VARIABLES "compensator/variables.h"
#include "compensator/model.c"
#include "laws/lugre/law.c"
#undef MODEL
#undef MODEL_H
#undef LAW_H
#undef LAW_IS_SMOOTH
#undef VARIABLES_H
#undef VARIABLES
#define MODEL controller
#define VARIABLES "velocity_controller/variables.h"
#include "velocity_controller/model.c"
#undef MODEL
#undef MODEL_H
#undef VARIABLES_H
#undef VARIABLES
#define MODEL drive
#define VARIABLES "drive/variables.h"
#include "drive/model.c"
#include "laws/lugre/law.c"
#include "laws/lugre/motion.c"

/* Run n steps of length h from the start values of inputs and states (in the order of the structs),
 * record position and reference velocity at n + 1 points in time. Returns 0, or 1 if a step failed.
 */
__attribute__((visibility("default"))) int run(size_t n, double h, const double v_cmd[],
                                               const double nominal_p[],
                                               const double compensator_p[],
                                               const double controller_p[], const double drive_p[],
                                               double x_enc[], double v_r[]) {
    const nominal_Parameters *const pn = (const nominal_Parameters *)nominal_p;
    const compensator_Parameters *const pf = (const compensator_Parameters *)compensator_p;
    const controller_Parameters *const pc = (const controller_Parameters *)controller_p;
    const drive_Parameters *const pd = (const drive_Parameters *)drive_p;
    nominal_Inputs un = {.v_cmd = v_cmd[0]};
    nominal_Memory wn = {0};
    nominal_Outputs yn = {0};
    compensator_Inputs uf = {0};
    compensator_States xf = {0};
    compensator_Memory wf = {0};
    compensator_Outputs yf = {0};
    controller_Inputs uc = {.v_cmd = v_cmd[0]};
    controller_Memory wc = {0};
    controller_Outputs yc = {0};
    drive_Inputs ud = {0};
    drive_States xd = {0};
    drive_Memory wd = {0};
    drive_Outputs yd = {0};

    nominal_start(0.0, NULL, &wn, &un, pn);
    nominal_outputs(0.0, NULL, &wn, &un, pn, &yn);
    uf.v = yn.v_r;
    compensator_start(0.0, &xf, &wf, &uf, pf);
    compensator_outputs(0.0, &xf, &wf, &uf, pf, &yf);
    uc.F_ff = yf.F_mean;
    controller_start(0.0, NULL, &wc, &uc, pc);
    controller_outputs(0.0, NULL, &wc, &uc, pc, &yc);
    ud.u = yc.u;
    drive_start(0.0, &xd, &wd, &ud, pd);
    drive_outputs(0.0, &xd, &wd, &ud, pd, &yd);
    x_enc[0] = yd.x_enc;
    v_r[0] = yn.v_r;
    for (size_t i = 0; i < n; i++) {
        const double t = (double)i * h, end = (double)(i + 1) * h, step = end - t;
        un.v_cmd = uc.v_cmd = v_cmd[i];
        if (!nominal_step(t, step, NULL, &wn, &un, pn))
            return 1;
        nominal_outputs(end, NULL, &wn, &un, pn, &yn);
        uf.v = yn.v_r;
        if (!compensator_step(t, step, &xf, &wf, &uf, pf))
            return 1;
        compensator_outputs(end, &xf, &wf, &uf, pf, &yf);
        uc.F_ff = yf.F_mean;
        uc.x_enc = yd.x_enc;
        if (!controller_step(t, step, NULL, &wc, &uc, pc))
            return 1;
        controller_outputs(end, NULL, &wc, &uc, pc, &yc);
        ud.u = yc.u;
        if (!drive_step(t, step, &xd, &wd, &ud, pd))
            return 1;
        drive_outputs(end, &xd, &wd, &ud, pd, &yd);
        x_enc[i + 1] = yd.x_enc;
        v_r[i + 1] = yn.v_r;
    }
    return 0;
}
