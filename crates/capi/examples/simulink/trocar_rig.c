/*
 * A sketch of a Simulink S-function (level 2, in C) that runs trocar's rig. This project does not compile it, because
 * it does not depend on MATLAB:
 *
 *     mex trocar_rig.c -I<prefix>/include -L<prefix>/lib -ltrocar_c
 *
 * Parameters: the tick (s), the position of the tissue surface (m), the position of the master at the start (m).
 * Input: master position (m), slave position (m), slave velocity (m/s), force (N).
 * Output: reference (m), force for the master (N), mode, alarm, stiffness (N/m), damping (N.s/m), decision function.
 * Each block has a rig in its work vector, so that code generation needs no allocator.
 */
#define S_FUNCTION_NAME trocar_rig
#define S_FUNCTION_LEVEL 2

#include "simstruc.h"
#include "trocar.h"

enum { TICK_S, CONTACT_M, START_M, PARAMETERS };
enum { INPUTS = 4, OUTPUTS = 7 };

static real_T parameter(SimStruct *S, int which)
{
    return mxGetScalar(ssGetSFcnParam(S, which));
}

static void mdlInitializeSizes(SimStruct *S)
{
    ssSetNumSFcnParams(S, PARAMETERS);
    if (ssGetNumSFcnParams(S) != ssGetSFcnParamsCount(S)) {
        return;
    }
    if (!ssSetNumInputPorts(S, 1) || !ssSetNumOutputPorts(S, 1)) {
        return;
    }
    ssSetInputPortWidth(S, 0, INPUTS);
    ssSetInputPortDirectFeedThrough(S, 0, 1);
    ssSetInputPortRequiredContiguous(S, 0, 1);
    ssSetOutputPortWidth(S, 0, OUTPUTS);
    ssSetNumSampleTimes(S, 1);
    /* The rig and its address. Doubles have the alignment of a rig (trocar_rig_alignment() is 8). */
    ssSetNumDWork(S, 1);
    ssSetDWorkWidth(S, 0, (int_T)((trocar_rig_size() + sizeof(real_T) - 1) / sizeof(real_T)));
    ssSetDWorkDataType(S, 0, SS_DOUBLE);
    ssSetNumPWork(S, 1);
}

static void mdlInitializeSampleTimes(SimStruct *S)
{
    ssSetSampleTime(S, 0, parameter(S, TICK_S));
    ssSetOffsetTime(S, 0, 0.0);
}

#define MDL_START
static void mdlStart(SimStruct *S)
{
    static char error[1024];
    trocar_rig_settings settings;
    trocar_rig *rig = NULL;
    size_t size = (size_t)ssGetDWorkWidth(S, 0) * sizeof(real_T);
    trocar_status status;

    trocar_rig_settings_default(&settings, sizeof settings);
    settings.simulation_tick_s = parameter(S, TICK_S);
    settings.estimator_contact_m = parameter(S, CONTACT_M);
    settings.rig_start_m = parameter(S, START_M);
    status = trocar_rig_init(ssGetDWork(S, 0), size, &settings, &rig, error, sizeof error);
    if (status != TROCAR_STATUS_OK) {
        ssSetErrorStatus(S, status == TROCAR_STATUS_SETTING ? error : trocar_status_text(status));
        return;
    }
    ssSetPWorkValue(S, 0, rig);
}

static void mdlOutputs(SimStruct *S, int_T tid)
{
    const real_T *in = ssGetInputPortRealSignal(S, 0);
    real_T *out = ssGetOutputPortRealSignal(S, 0);
    trocar_sample sample = {sizeof sample, in[0], in[1], in[2], in[3]};
    trocar_command command;
    trocar_status status;

    (void)tid;
    command.struct_size = sizeof command;
    status = trocar_rig_step(ssGetPWorkValue(S, 0), &sample, &command);
    if (status != TROCAR_STATUS_OK) {
        ssSetErrorStatus(S, trocar_status_text(status));
        return;
    }
    out[0] = command.slave_reference_m;
    out[1] = command.master_force_n;
    out[2] = command.mode;
    out[3] = command.alarm;
    out[4] = command.stiffness_n_per_m;
    out[5] = command.damping_n_s_per_m;
    out[6] = command.decision;
}

static void mdlTerminate(SimStruct *S)
{
    (void)S;
}

#ifdef MATLAB_MEX_FILE
#include "simulink.c"
#else
#include "cg_sfun.h"
#endif
