// Copyright 2026 gearbox_monitor authors
// SPDX-License-Identifier: Apache-2.0

import java.util.Locale;

import org.hipparchus.analysis.differentiation.Gradient;
import org.hipparchus.filtering.kalman.Measurement;
import org.hipparchus.filtering.kalman.ProcessEstimate;
import org.hipparchus.filtering.kalman.extended.ExtendedKalmanFilter;
import org.hipparchus.filtering.kalman.extended.NonLinearEvolution;
import org.hipparchus.filtering.kalman.extended.NonLinearProcess;
import org.hipparchus.filtering.kalman.unscented.UnscentedEvolution;
import org.hipparchus.filtering.kalman.unscented.UnscentedKalmanFilter;
import org.hipparchus.filtering.kalman.unscented.UnscentedProcess;
import org.hipparchus.linear.MatrixUtils;
import org.hipparchus.linear.QRDecomposer;
import org.hipparchus.linear.RealMatrix;
import org.hipparchus.linear.RealVector;
import org.hipparchus.util.MerweUnscentedTransform;

/**
 * The EKF and the UKF of Hipparchus over a drive: filters.csv.
 *
 * <p>State x1, x2, x3, x4, tau_K: angles and speeds of motor and arm, torque of the gearbox as a
 * random walk. One RK4 step a sample; the tangent is its derivative, by automatic
 * differentiation. Half of the process noise acts before the step, half after it, so that a filter
 * starts anew at each sample. The input is a chirp; the readings are those of a linear spring, with
 * a deterministic sequence as noise.
 *
 * <p>With the JARs hipparchus-core and hipparchus-filtering 3.1 in CLASSPATH:
 * {@code java test/truth/Filters.java > test/truth/filters.csv}
 */
public final class Filters {
    private static final double DT = 1e-3;
    private static final double M1 = 0.0065, M2 = 0.023, D = 0.02, CV = 0.1, CC = 0.27,
        ALPHA = 8.0, KR = 0.01, STIFFNESS = 25.0;
    private static final double[] Q = {1e-4, 1e-4, 0.1, 0.2, 100.0};  // spectral densities
    private static final double[] R = {0.004, 0.006};                 // deviations, rad
    private static final double P0 = 0.5;
    private static final double W_ALPHA = 0.7, W_BETA = 2.0, W_KAPPA = 1.0;
    private static final int SAMPLES = 200;

    private Filters() { }

    /** A reading of both encoders, after the torque u has acted for DT. */
    private record Reading(double time, double u, RealVector value) implements Measurement {
        @Override public double getTime() { return time; }
        @Override public RealVector getValue() { return value; }
        @Override public RealMatrix getCovariance() {
            return MatrixUtils.createRealDiagonalMatrix(new double[] {R[0] * R[0], R[1] * R[1]});
        }
    }

    private static Gradient[] derivative(Gradient[] x, double u) {
        Gradient shared = x[2].subtract(x[3]).multiply(D).add(x[4]);
        Gradient friction = x[2].multiply(CV).add(
            x[2].multiply(ALPHA).atan().multiply(2.0 * CC / Math.PI));
        Gradient motor = shared.add(friction).add(x[0].multiply(KR)).negate().add(u).divide(M1);
        return new Gradient[] {x[2], x[3], motor, shared.divide(M2), x[4].multiply(0.0)};
    }

    private static Gradient[] moved(Gradient[] x, Gradient[] k, double h) {
        Gradient[] out = new Gradient[x.length];
        for (int i = 0; i < x.length; i++) {
            out[i] = x[i].add(k[i].multiply(h));
        }
        return out;
    }

    /** The state after one RK4 step, with its derivatives by the state before. */
    private static Gradient[] step(RealVector state, double u) {
        Gradient[] x = new Gradient[5];
        for (int i = 0; i < 5; i++) {
            x[i] = Gradient.variable(5, i, state.getEntry(i));
        }
        Gradient[] k1 = derivative(x, u);
        Gradient[] k2 = derivative(moved(x, k1, 0.5 * DT), u);
        Gradient[] k3 = derivative(moved(x, k2, 0.5 * DT), u);
        Gradient[] k4 = derivative(moved(x, k3, DT), u);
        Gradient[] out = new Gradient[5];
        for (int i = 0; i < 5; i++) {
            out[i] = x[i].add(k1[i].add(k2[i].multiply(2)).add(k3[i].multiply(2)).add(k4[i])
                .multiply(DT / 6.0));
        }
        return out;
    }

    private static RealVector values(Gradient[] x) {
        double[] out = new double[x.length];
        for (int i = 0; i < x.length; i++) {
            out[i] = x[i].getValue();
        }
        return MatrixUtils.createRealVector(out);
    }

    private static RealMatrix tangent(Gradient[] x) {
        double[][] out = new double[x.length][];
        for (int i = 0; i < x.length; i++) {
            out[i] = x[i].getGradient();
        }
        return MatrixUtils.createRealMatrix(out);
    }

    private static RealMatrix halfNoise() {
        return MatrixUtils.createRealDiagonalMatrix(Q).scalarMultiply(0.5 * DT);
    }

    private static final class Extended implements NonLinearProcess<Reading> {
        @Override public NonLinearEvolution getEvolution(double t, RealVector state, Reading y) {
            Gradient[] next = step(state, y.u());
            double[][] h = {{1, 0, 0, 0, 0}, {0, 1, 0, 0, 0}};
            return new NonLinearEvolution(y.getTime(), values(next), tangent(next), halfNoise(),
                                          MatrixUtils.createRealMatrix(h));
        }

        @Override public RealVector getInnovation(Reading y, NonLinearEvolution e, RealMatrix s) {
            return y.getValue().subtract(e.getCurrentState().getSubVector(0, 2));
        }
    }

    private static final class Unscented implements UnscentedProcess<Reading> {
        @Override public UnscentedEvolution getEvolution(double t, RealVector[] points, Reading y) {
            RealVector[] next = new RealVector[points.length];
            for (int i = 0; i < points.length; i++) {
                next[i] = values(step(points[i], y.u()));
            }
            return new UnscentedEvolution(y.getTime(), next, halfNoise());
        }

        @Override public RealVector[] getPredictedMeasurements(RealVector[] points, Reading y) {
            RealVector[] out = new RealVector[points.length];
            for (int i = 0; i < points.length; i++) {
                out[i] = points[i].getSubVector(0, 2);
            }
            return out;
        }

        @Override public RealVector getInnovation(Reading y, RealVector predicted, RealVector x,
                                                  RealMatrix s) {
            return y.getValue().subtract(predicted);
        }
    }

    private static ProcessEstimate begun(ProcessEstimate e) {
        RealMatrix p = e.getCovariance();
        p = p.add(p.transpose()).scalarMultiply(0.5);
        return new ProcessEstimate(e.getTime(), e.getState(), p.add(halfNoise()));
    }

    private static void print(double... row) {
        StringBuilder text = new StringBuilder();
        for (double x : row) {
            text.append(text.length() > 0 ? "," : "").append(String.format(Locale.ROOT, "%.17g", x));
        }
        System.out.println(text);
    }

    /** Prints a row a sample: torque, readings, then state and deviations of EKF and UKF. */
    public static void main(String[] args) {
        double[] x = new double[4];
        double[] start = {0.0, 0.0, 0.0, 0.0, 0.0};
        ProcessEstimate ekf = new ProcessEstimate(
            0.0, MatrixUtils.createRealVector(start),
            MatrixUtils.createRealIdentityMatrix(5).scalarMultiply(P0 * P0));
        ProcessEstimate ukf = ekf;
        long sequence = 1;
        for (int k = 0; k < SAMPLES; k++) {
            double t = k * DT;
            double u = 0.9 * Math.sin(2.0 * Math.PI * (3.0 + 12.0 * t) * t);
            for (int i = 0; i < 50; i++) {          // of the plant, finer than the filters' steps
                double h = DT / 50.0;
                double shared = D * (x[2] - x[3]) + STIFFNESS * (x[0] - x[1]);
                double friction = CV * x[2] + 2.0 * CC / Math.PI * Math.atan(ALPHA * x[2]);
                x[2] += h * (u - shared - friction - KR * x[0]) / M1;
                x[3] += h * shared / M2;
                x[0] += h * x[2];
                x[1] += h * x[3];
            }
            double[] y = new double[2];
            for (int i = 0; i < 2; i++) {           // uniform, of the deviation R
                sequence = sequence * 6364136223846793005L + 1442695040888963407L;
                y[i] = x[i] + R[i] * Math.sqrt(12.0) * ((sequence >>> 11) * 0x1.0p-53 - 0.5);
            }
            Reading reading = new Reading(t + DT, u, MatrixUtils.createRealVector(y));
            ekf = new ExtendedKalmanFilter<>(new QRDecomposer(1e-15), new Extended(),
                                             begun(ekf)).estimationStep(reading);
            ukf = new UnscentedKalmanFilter<>(
                new QRDecomposer(1e-15), new Unscented(), begun(ukf),
                new MerweUnscentedTransform(5, W_ALPHA, W_BETA, W_KAPPA)).estimationStep(reading);
            double[] row = new double[23];
            row[0] = u;
            row[1] = y[0];
            row[2] = y[1];
            for (int i = 0; i < 5; i++) {
                row[3 + i] = ekf.getState().getEntry(i);
                row[8 + i] = Math.sqrt(ekf.getCovariance().getEntry(i, i));
                row[13 + i] = ukf.getState().getEntry(i);
                row[18 + i] = Math.sqrt(ukf.getCovariance().getEntry(i, i));
            }
            print(row);
        }
    }
}
